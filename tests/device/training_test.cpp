#include <torch/torch.h>

#include <catch2/catch.hpp>

#include <cmath>

#include "core/temporary_folder.h"
#include "device/test_device.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/files/files.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/diffsac_network.h"
#include "lab/torch/process_group.h"
#include "lab/torch/spawn_ranks.h"
#include "lab/train/train_request.h"

namespace diffsac {
namespace {

using testing::TestDevice;
using testing::TestDeviceName;

const char* kCommon = R"(
name: tiny
task: line
data: {type: synthetic_line, num_points: [30, 40], outlier_ratio: [0.1, 0.5]}
train: {iterations: 8, batch_size: 4, warmup_iterations: 2, log_every: 1, validate_every: 4, checkpoint_every: 2,
        learning_rate: 0.003, clip_norm: 0.05, ema_decay: 0.9}
validation: {problems: 4, outlier_ratios: [0.2]}
)";

const char* kDiffsac = R"(
network:
  features: {kinds: [residual], residual_draws: 20, residual_kept: 4}
  denoiser: {kind: pooled, width: 16, encoder_layers: 1, layers: 1, relation: true}
inference: {num_diffusion_samples: 4, sampler: {steps: 2}}
train: {noise_copies: 2, precision: float32, positive_weight: 4}
)";

const char* kNgRansac = R"(
method: ng_ransac
network: {features: {kinds: [residual], residual_draws: 20, residual_kept: 4}, width: 16, blocks: 2}
ng_ransac: {initialization_iterations: 3, hypotheses: 2, pools: 3}
inference: {max_iterations: 5}
)";

const char* kClnet = R"(
method: clnet
network: {features: {kinds: [residual], residual_draws: 20, residual_kept: 4}, width: 16, fewest: 8}
)";

TrainRequest Request(const char* method, const std::string& output, const std::string& device,
                     const std::vector<std::string>& changes = {}) {
  const auto config = ConfigFromYaml(kCommon, "tiny.yaml").MergedWith(ConfigFromYaml(method, "tiny.yaml"));
  TrainRequest request = OneThread(config, output, changes);
  request.device = device;
  return request;
}

std::string Last(const std::string& run) { return run + "/checkpoints/last.safetensors"; }

// The columns of metrics.csv that are losses, one after another; NaN where there is none.
std::vector<double> Losses(const std::string& run) {
  const auto metrics = Metrics(run);
  std::vector<double> losses;
  for (const std::string& name : metrics.at(0)) {
    const auto values = name.starts_with("loss_") ? Column(metrics, name) : std::vector<double>();
    losses.insert(losses.end(), values.begin(), values.end());
  }
  return losses;
}

// The largest difference relative to the larger; no loss counts as the same as none.
double Difference(const std::vector<double>& a, const std::vector<double>& b) {
  REQUIRE(a.size() == b.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(std::isnan(a[i]) == std::isnan(b[i]));
    if (!std::isnan(a[i]) && a[i] != b[i])
      worst = std::max(worst, std::abs(a[i] - b[i]) / std::max({std::abs(a[i]), std::abs(b[i]), 0.1}));
  }
  return worst;
}

// Whether rounding leaves a training about as it was. CLNet keeps the likelier half of the points, whichever these are,
// and a GPU's rounding makes others of them: on an H200 its losses were a quarter off after eight steps.
bool Compares(const char* method) { return testing::OnOwnDevice() || method != kClnet; }

}  // namespace

TEST_CASE("every method trains on the device as on the CPU, and its checkpoint serves both") {
  for (const char* method : {kDiffsac, kNgRansac, kClnet}) {
    CAPTURE(method);
    const TemporaryFolder folder;
    const auto there = folder / "there", here = folder / "here";
    REQUIRE(Train(Request(method, there, TestDeviceName()), kNever) == TrainOutcome::kFinished);
    REQUIRE(Train(Request(method, here, "cpu"), kNever) == TrainOutcome::kFinished);
    if (Compares(method)) CHECK(Difference(Losses(there), Losses(here)) < 0.01);
    for (const std::string& device : {TestDeviceName(), std::string("cpu")}) {
      const auto trained = ReadTrainedConfig(there + "/checkpoints/best.safetensors");
      const std::string row = "{type: " + trained.method + ", checkpoint: '" + trained.checkpoint + "'}";
      CHECK(MakeEstimator(ConfigFromYaml(row), Task::kLine, {"", device, 1})->Training()->parameters > 0);
    }
  }
}

TEST_CASE("a training on the device that was stopped and resumed equals one that was not") {
  for (const char* method : {kDiffsac, kNgRansac, kClnet}) {
    CAPTURE(method);
    const TemporaryFolder folder;
    const auto whole = folder / "whole", parts = folder / "parts";
    const std::vector<std::string> longer = {"train.iterations=24", "train.validate_every=24"};
    REQUIRE(Train(Request(method, whole, TestDeviceName(), longer), kNever) == TrainOutcome::kFinished);
    const TrainRequest request = Request(method, parts, TestDeviceName(), longer);
    REQUIRE(TrainUntil(request, [&] { return Metrics(parts).size() >= 6; }) == TrainOutcome::kStopped);
    REQUIRE(Resume(request) == TrainOutcome::kFinished);
    if (Compares(method)) CHECK(Difference(Losses(whole), Losses(parts)) < (testing::OnOwnDevice() ? 1e-300 : 0.02));
    // Sums of atomic additions on a GPU come in any order.
    if (testing::OnOwnDevice()) CHECK(ReadFile(Last(whole)) == ReadFile(Last(parts)));
  }
}

TEST_CASE("a training goes on from another device's checkpoint") {
  const TemporaryFolder folder;
  const auto whole = folder / "whole", parts = folder / "parts";
  REQUIRE(Train(Request(kDiffsac, whole, "cpu"), kNever) == TrainOutcome::kFinished);
  TrainUntil(Request(kDiffsac, parts, "cpu"), [&] { return Metrics(parts).size() >= 3; });
  REQUIRE(Resume(Request(kDiffsac, parts, TestDeviceName())) == TrainOutcome::kFinished);
  CHECK(Difference(Losses(whole), Losses(parts)) < 0.01);
}

TEST_CASE("every denoiser trains on the device in either precision") {
  for (const std::string kind : {"point_transformer", "pooled", "mlp", "dgcnn"}) {
    CAPTURE(kind);
    const TemporaryFolder folder;
    int runs = 0;
    const auto train = [&](const std::string& device, const std::string& precision) {
      const auto run = folder / std::to_string(runs++);
      std::vector<std::string> changes = {"network.denoiser.kind=" + kind, "train.precision=" + precision,
                                          "train.iterations=4"};
      REQUIRE(Train(Request(kDiffsac, run, device, changes), kNever) == TrainOutcome::kFinished);
      return Losses(run);
    };
    const auto here = train("cpu", "float32");
    CHECK(Difference(train(TestDeviceName(), "float32"), here) < 0.01);
    CHECK(Difference(train(TestDeviceName(), "bfloat16"), here) < 0.1);
  }
}

TEST_CASE("precision auto on a device that is not the CPU is bfloat16") {
  if (TestDevice().is_cpu()) return;
  const TemporaryFolder folder;
  const auto losses = [&](const std::string& precision) {
    const auto run = folder / precision;
    Train(Request(kDiffsac, run, TestDeviceName(), {"train.precision=" + precision, "train.iterations=3"}), kNever);
    return Losses(run);
  };
  const auto automatic = losses("auto");
  CHECK(Difference(automatic, losses("bfloat16")) < 1e-3);
  CHECK(Difference(automatic, losses("float32")) > 1e-5);
}

// Run by the test below in processes of their own.
TEST_CASE("worker: trains on the device", "[.]") {
  const auto group = JoinProcessGroup(60.0);
  auto request = Request(kDiffsac, std::getenv("DIFFSAC_TEST_OUTPUT"), TestDeviceName());
  request.group = group.get();
  CHECK(Train(request, kNever) == TrainOutcome::kFinished);
}

TEST_CASE("processes sum gradients that are on the device") {
  const TemporaryFolder folder;
  const auto alone = folder / "alone", together = folder / "together";
  REQUIRE(Train(Request(kDiffsac, alone, TestDeviceName()), kNever) == TrainOutcome::kFinished);
  const testing::Variables variables = {{"DIFFSAC_TEST_OUTPUT", together}};
  REQUIRE(testing::RunRanks("worker: trains on the device", 2, variables) == std::vector<int>{0, 0});
  CHECK(Difference(Losses(alone), Losses(together)) < 0.01);
}

}  // namespace diffsac
