#include "lab/train/distributed.h"
#include "lab/config/yaml.h"

#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/files/files.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/diffsac_network.h"
#include "lab/torch/ng_ransac.h"
#include "lab/torch/spawn_ranks.h"
#include "lab/train/train_request.h"
#include "lab/train/trainer.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using testing::RunRanks;

// Problems of different sizes and a weight of positives: what makes the mean of ranks' means another than the joint
// mean.
const char* kTiny = R"(
name: tiny
task: line
data: {type: synthetic_line, num_points: [12, 60], outlier_ratio: [0.1, 0.5]}
network:
  features: {kinds: [residual], residual_draws: 20, residual_kept: 4}
  denoiser: {kind: pooled, width: 16, encoder_layers: 1, layers: 1}
train: {iterations: 20, batch_size: 4, noise_copies: 2, warmup_iterations: 5, log_every: 1, validate_every: 10,
        checkpoint_every: 10, learning_rate: 0.001, precision: float32, positive_weight: 4}
validation: {problems: 8, outlier_ratios: [0.2]}
inference: {num_diffusion_samples: 4, sampler: {steps: 2}}
)";

// From the fifth step on minimal sets are drawn, which must not depend on who draws them.
const char* kTinyNgRansac = R"(
name: tiny
method: ng_ransac
task: line
data: {type: synthetic_line, num_points: [12, 60], outlier_ratio: [0.1, 0.5]}
network: {features: {kinds: [residual], residual_draws: 20, residual_kept: 4}, width: 16, blocks: 2}
ng_ransac: {initialization_iterations: 5, hypotheses: 2, pools: 3}
train: {iterations: 12, batch_size: 4, warmup_iterations: 5, log_every: 1, validate_every: 12, checkpoint_every: 12,
        learning_rate: 0.001}
validation: {problems: 8, outlier_ratios: [0.2]}
inference: {max_iterations: 5}
)";

TrainRequest Request(const std::string& output, const char* config = kTiny,
                     const std::vector<std::string>& changes = {}) {
  return OneThread(ConfigFromYaml(config, "tiny.yaml"), output, changes);
}

// The largest difference of two runs' weights, and the largest weight.
std::pair<double, double> Compare(const torch::nn::Module& a, const torch::nn::Module& b) {
  double difference = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < a.parameters().size(); ++i) {
    const auto p = a.parameters()[i], q = b.parameters()[i];
    difference = std::max(difference, (p - q).abs().max().item<double>());
    largest = std::max(largest, p.abs().max().item<double>());
  }
  return {difference, largest};
}

}  // namespace

TEST_CASE("worker: trains", "[.]") {
  const auto group = JoinProcessGroup(60.0);
  const bool ng_ransac = std::getenv("DIFFSAC_TEST_NG_RANSAC") != nullptr;
  std::vector<std::string> changes;
  if (const char* change = std::getenv("DIFFSAC_TEST_CHANGE"); change != nullptr && group->rank() == 1)
    changes.push_back(change);
  TrainRequest request = Request(std::getenv("DIFFSAC_TEST_OUTPUT"), ng_ransac ? kTinyNgRansac : kTiny, changes);
  request.group = group.get();
  if (const char* error = std::getenv("DIFFSAC_TEST_ERROR")) {
    CHECK_THROWS_WITH(Train(request, kNever), Contains(error));
    return;
  }
  CHECK(Train(request, kNever) == TrainOutcome::kFinished);
}

TEST_CASE("processes train what one process does with the joint batch") {
  const TemporaryFolder folder;
  const auto alone = folder / "alone";
  REQUIRE(Train(Request(alone), kNever) == TrainOutcome::kFinished);
  for (const int size : {2, 3}) {  // Three processes have one, one and two of the four problems.
    const auto together = folder / std::to_string(size);
    REQUIRE(RunRanks("worker: trains", size, {{"DIFFSAC_TEST_OUTPUT", together}}) == std::vector<int>(size, 0));
    const auto last = [](const std::string& run) {
      return LoadNetwork(ReadTrainedConfig(run + "/checkpoints/last.safetensors", "diffsac", Task::kLine), torch::kCPU);
    };
    const auto [difference, largest] = Compare(*last(alone)->module, *last(together)->module);
    // Sums of floats in another order, after 20 steps of 0.001.
    INFO(difference << " of " << largest);
    CHECK(difference < 1e-4);
    CHECK(fs::exists(together + "/checkpoints/best.safetensors"));
    CHECK(fs::exists(together + "/metrics.csv"));
  }
}

TEST_CASE("processes train ng_ransac's expected loss as one process does") {
  const TemporaryFolder folder;
  const auto alone = folder / "alone", together = folder / "together";
  REQUIRE(Train(Request(alone, kTinyNgRansac), kNever) == TrainOutcome::kFinished);
  REQUIRE(RunRanks("worker: trains", 2, {{"DIFFSAC_TEST_OUTPUT", together}, {"DIFFSAC_TEST_NG_RANSAC", "1"}}) ==
          std::vector<int>{0, 0});
  // What the networks say is compared: a bias in front of a normalisation has no gradient but rounding, which Adam
  // makes steps of.
  torch::manual_seed(1);
  const auto features = torch::randn({1, 50, 12});
  const auto weights = [&](const std::string& run) {
    const torch::NoGradGuard no_grad;
    const auto last = LoadLearnedWeights<NgRansacNetwork>(
        ReadTrainedConfig(run + "/checkpoints/last.safetensors", NgRansacNetwork::kMethod, Task::kLine), torch::kCPU);
    return last->module->Weights({features, {}, {50}});
  };
  const auto expected = weights(alone);
  const double difference = (weights(together) / expected - 1.0).abs().max().item<double>();
  INFO(difference << ", spread " << (expected.max() / expected.min()).item<double>());
  CHECK(difference < 1e-4);
}

TEST_CASE("processes with different configurations don't train") {
  const TemporaryFolder folder;
  CHECK(RunRanks("worker: trains", 2,
                 {{"DIFFSAC_TEST_OUTPUT", folder / "run"},
                  {"DIFFSAC_TEST_CHANGE", "train.learning_rate=0.002"},
                  {"DIFFSAC_TEST_ERROR", "processes 0 and 1 have different configurations"}}) ==
        std::vector<int>{0, 0});
  CHECK(RunRanks("worker: trains", 5,
                 {{"DIFFSAC_TEST_OUTPUT", folder / "run"},
                  {"DIFFSAC_TEST_ERROR", "4 problems a step for 5 processes"}}) == std::vector<int>(5, 0));
}

TEST_CASE("a process alone takes every item with its full weight") {
  const TrainingTeam team(nullptr, 6);
  CHECK(team.main());
  CHECK(team.batch() == 6);
  for (std::uint64_t k = 0; k < 20; ++k) CHECK(team.ItemIndex(k) == k);
  CHECK(team.Shares({3.0, 0.25}) == std::vector<double>{1.0, 1.0});
  CHECK(team.Any(true));
  CHECK_FALSE(team.Any(false));
}

TEST_CASE("loss weights count what the losses average over") {
  TrainingItem item;
  item.inliers = {1, 0, 1};
  item.labels = {{0, 2}, {2}};
  CHECK(DiffusionLossWeights({item, item}, 2, 1.0) == std::vector<double>{12.0, 6.0});
  CHECK(DiffusionLossWeights({item, item}, 2, 4.0) == std::vector<double>{30.0, 6.0});
}

}  // namespace diffsac
