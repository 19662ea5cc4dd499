#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <numeric>

#include "core/temporary_folder.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/data/synthetic.h"
#include "lab/eval/metrics.h"
#include "lab/files/files.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/clnet.h"
#include "lab/torch/ng_ransac.h"
#include "lab/torch/weighted_estimator.h"
#include "lab/train/expected_loss.h"
#include "lab/train/train_request.h"
#include "lab/train/trainer.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

const char* kCommon = R"(
name: tiny
task: line
data: {type: synthetic_line, num_points: [40, 50], outlier_ratio: 0.6}
train: {iterations: 60, batch_size: 8, warmup_iterations: 5, log_every: 1, validate_every: 60, checkpoint_every: 10,
        learning_rate: 0.003, ema_decay: 0.95}
validation: {problems: 8, outlier_ratios: [0.5]}
)";

const char* kNgRansac = R"(
method: ng_ransac
network: {features: {kinds: [residual], residual_draws: 20, residual_kept: 4}, width: 16, blocks: 2}
ng_ransac: {initialization_iterations: 30, hypotheses: 2, pools: 4}
inference: {max_iterations: 5}
)";

const char* kClnet = R"(
method: clnet
network: {features: {kinds: [residual], residual_draws: 20, residual_kept: 4}, width: 16, fewest: 8}
)";

TrainRequest Request(const char* method, const std::string& output, const std::vector<std::string>& changes = {}) {
  return OneThread(ConfigFromYaml(std::string(kCommon) + method, "tiny.yaml"), output, changes);
}

// Of rows counted from 1.
double Mean(const std::vector<std::vector<std::string>>& metrics, const std::string& column, int first, int last) {
  const auto values = Column(metrics, column);
  return std::accumulate(values.begin() + first - 1, values.begin() + last, 0.0) / (last - first + 1);
}

}  // namespace

TEST_CASE("NG-RANSAC's initialisation lowers the divergence, and its sets have more inliers than uniform ones") {
  const TemporaryFolder folder;
  const auto output = folder / "run";
  REQUIRE(Train(Request(kNgRansac, output, {"ng_ransac.initialization_iterations=60"}), kNever) ==
          TrainOutcome::kFinished);
  const auto table = Metrics(output);
  REQUIRE(table.size() == 61);
  CHECK(Mean(table, "loss_target", 51, 60) < 0.8 * Mean(table, "loss_target", 1, 3));

  // The paper's claim: learned weights find better models than uniform sampling at the same budget.
  const auto weights = LoadLearnedWeights<NgRansacNetwork>(
      ReadTrainedConfig(output + "/checkpoints/last.safetensors", NgRansacNetwork::kMethod, Task::kLine), torch::kCPU);
  WeightedEstimatorOptions options;
  options.max_iterations = 3;
  const WeightedEstimator method(weights, options, 1);
  SyntheticOptions data;
  data.outlier_ratio = {0.6, 0.6};
  data.num_points = 50;
  data.split = "test";
  const auto dataset = MakeSynthetic(Task::kLine, data, 1);
  int good = 0, total = 0;
  for (int i = 0; i < 40; ++i) {
    const auto example = dataset->Get(i);
    for (const auto& set : method.Run(example.problem, i).minimal_sets) {
      good += example.truth.inliers[set[0]] && example.truth.inliers[set[1]];
      ++total;
    }
  }
  CHECK(total == 120);
  CHECK(good > 0.35 * total);  // uniform sampling: 0.16
}

TEST_CASE("NG-RANSAC's training by the expected loss alone lowers it") {
  const TemporaryFolder folder;
  const auto output = folder / "run";
  REQUIRE(Train(Request(kNgRansac, output,
                        {"train.iterations=120", "ng_ransac.initialization_iterations=0", "ng_ransac.rate_factor=1"}),
                kNever) == TrainOutcome::kFinished);
  const auto table = Metrics(output);
  CHECK(Mean(table, "loss_expected", 81, 120) < 0.85 * Mean(table, "loss_expected", 1, 20));
}

TEST_CASE("CLNet's training lowers its losses, pruning keeps a larger share of the inliers than of the outliers") {
  const TemporaryFolder folder;
  const auto output = folder / "run";
  REQUIRE(Train(Request(kClnet, output, {"train.iterations=100", "data.outlier_ratio=0.7"}), kNever) ==
          TrainOutcome::kFinished);
  const auto table = Metrics(output);
  CHECK(Mean(table, "loss_pruning", 91, 100) < 0.85 * Mean(table, "loss_pruning", 1, 5));
  CHECK(Mean(table, "loss_candidates", 91, 100) < Mean(table, "loss_candidates", 1, 5));
  CHECK(Mean(table, "kept_inliers", 91, 100) > 0.5);  // a quarter of the points is left

  const auto weights = LoadLearnedWeights<ClnetNetwork>(
      ReadTrainedConfig(output + "/checkpoints/last.safetensors", ClnetNetwork::kMethod, Task::kLine), torch::kCPU);
  SyntheticOptions data;
  data.outlier_ratio = {0.7, 0.7};
  data.num_points = 50;
  data.split = "test";
  const auto dataset = MakeSynthetic(Task::kLine, data, 1);
  double inlier_weight = 0.0, outlier_weight = 0.0;
  int answered = 0;
  const WeightedEstimator method(weights, DefaultWeightedOptions("clnet"), 1);
  for (int i = 0; i < 40; ++i) {
    const auto example = dataset->Get(i);
    const NormalizedProblem space(example.problem);
    const std::uint64_t seed = i;
    const auto prediction = method.Predict({&space, 1}, {&seed, 1})[0];
    for (std::size_t j = 0; j < prediction.weights.size(); ++j)
      (example.truth.inliers[j] ? inlier_weight : outlier_weight) += prediction.weights[j];
    const auto estimate = method.Run(example.problem, seed);
    answered += estimate.status == Status::kOk;
    CHECK(estimate.minimal_sets.empty());
  }
  CHECK(inlier_weight > outlier_weight);  // 15 inliers among 50 points
  CHECK(answered > 30);                   // a fit without any inlier is no model; which ones is rounding
}

TEST_CASE("a learned row that was stopped and resumed equals one that was not") {
  for (const char* method : {kNgRansac, kClnet}) {
    const TemporaryFolder folder;
    const auto whole = folder / "whole", parts = folder / "parts";
    const std::vector<std::string> brief = {"train.iterations=36", "train.validate_every=36", "train.batch_size=4"};
    REQUIRE(Train(Request(method, whole, brief), kNever) == TrainOutcome::kFinished);
    REQUIRE(TrainUntil(Request(method, parts, brief), [&] { return Metrics(parts).size() >= 8; }) ==
            TrainOutcome::kStopped);
    REQUIRE(Resume(Request(method, parts, brief)) == TrainOutcome::kFinished);
    CHECK(Metrics(whole) == Metrics(parts));
  }
}

TEST_CASE("rows of learned methods read their checkpoint, and wrong ones are clear errors") {
  const TemporaryFolder folder;
  std::atomic<bool> now{true};
  const auto ng = folder / "ng", cl = folder / "cl";
  REQUIRE(Train(Request(kNgRansac, ng), now) == TrainOutcome::kStopped);
  REQUIRE(Train(Request(kClnet, cl), now) == TrainOutcome::kStopped);
  const auto path = [](const std::string& run) { return run + "/checkpoints/last.safetensors"; };
  const auto make = [](const std::string& type, const std::string& checkpoint, const std::string& more = "",
                       Task task = Task::kLine, const std::string& override_path = "") {
    return MakeEstimator(ConfigFromYaml("{type: " + type + ", checkpoint: '" + checkpoint + "'" + more + "}", "t.yaml"),
                         task, {override_path, "cpu", 1});
  };
  SyntheticOptions data;
  data.outlier_ratio = {0.3, 0.3};
  const auto problem = MakeSynthetic(Task::kLine, data, 1)->Get(0).problem;
  const auto budget = [&](const std::unique_ptr<RobustEstimator>& method) {
    return method->Run(problem, 1).stats.hypotheses;
  };
  const std::string plain = ", consensus: {refit: none}";
  CHECK(budget(make("ng_ransac", path(ng), plain)) == 20 + 5);  // as in the checkpoint
  CHECK(budget(make("ng_ransac", path(ng), plain + ", max_iterations: 9")) == 20 + 9);
  CHECK(budget(make("clnet", path(cl), plain)) == 20 + 1);  // one weighted fit
  CHECK(budget(make("clnet", path(cl), plain + ", max_iterations: 4")) == 20 + 4 + 1);
  CHECK(make("ng_ransac", "none.safetensors", "", Task::kLine, path(ng)) != nullptr);
  CHECK_THROWS_WITH(make("ng_ransac", "none.safetensors", "", Task::kLine, path(cl)),
                    Catch::Contains("none.safetensors"));
  CHECK_THROWS_WITH(make("clnet", path(ng)), Catch::Contains("'ng_ransac'") && Catch::Contains("'clnet'"));
  CHECK_THROWS_WITH(make("diffsac", path(ng)), Catch::Contains("'ng_ransac'") && Catch::Contains("'diffsac'"));
  CHECK_THROWS_WITH(make("ng_ransac", path(ng), "", Task::kPlane), Catch::Contains("line") && Catch::Contains("plane"));
  CHECK_THROWS_WITH(make("ng_ransac", path(ng), ", num_diffusion_samples: 3"),
                    Catch::Contains("num_diffusion_samples"));
  CHECK_THROWS_WITH(make("clnet", path(cl), ", weighted_fit: false"), Catch::Contains("max_iterations"));
  CHECK_THROWS_WITH(make("clnett", path(cl)), Catch::Contains("clnet"));
}

TEST_CASE("keys of another method are refused, and the place is named") {
  const TemporaryFolder folder;
  const auto run = [&](const char* method, const std::string& change) {
    Train(Request(method, folder / "a", {change}), kNever);
  };
  CHECK_THROWS_WITH(run(kNgRansac, "train.noise_copies=2"), Catch::Contains("noise_copies"));
  CHECK_THROWS_WITH(run(kNgRansac, "network.denoiser.width=8"), Catch::Contains("denoiser"));
  CHECK_THROWS_WITH(run(kNgRansac, "clnet.temperature=1"), Catch::Contains("clnet"));
  CHECK_THROWS_WITH(run(kNgRansac, "labels.top_m=1"), Catch::Contains("labels"));
  CHECK_THROWS_WITH(run(kNgRansac, "ng_ransac.pools=1"), Catch::Contains("pools"));
  CHECK_THROWS_WITH(run(kNgRansac, "method=ngransac"), Catch::Contains("did you mean") || Catch::Contains("ng_ransac"));
  CHECK_THROWS_WITH(run(kClnet, "network.neighbors=[9, 5]"), Catch::Contains("annulus"));
  CHECK_THROWS_WITH(run(kClnet, "inference.num_diffusion_samples=5"), Catch::Contains("num_diffusion_samples"));
  CHECK_THROWS_WITH(run(kClnet, "task=plane"), Catch::Contains("plane"));
}

}  // namespace diffsac
