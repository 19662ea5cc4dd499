#include <torch/torch.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/temporary_folder.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/data/synthetic.h"
#include "lab/files/files.h"
#include "lab/train/expected_loss.h"
#include "lab/train/train_request.h"
#include "lab/train/training_source.h"

namespace diffsac {
namespace {

const char* kTiny = R"(
name: tiny
task: line
data: {type: synthetic_structures, task: line, structures: [2, 3], num_points: 40}
network:
  features: {kinds: [residual], residual_draws: 60, residual_kept: 8, residual_choice: spread}
  denoiser: {kind: pooled, width: 16, encoder_layers: 1, layers: 1, relation: true}
labels: {target: structure}
train: {iterations: 6, batch_size: 4, noise_copies: 2, warmup_iterations: 2, log_every: 3, validate_every: 3, checkpoint_every: 3}
validation: {problems: 4, outlier_ratios: [0.2]}
inference: {num_diffusion_samples: 8, sampler: {kind: ddim, steps: 2}, feature_hypotheses: true, instances: {search: at_once}}
)";

std::shared_ptr<const Dataset> Lines(int instances) {
  SyntheticInstancesOptions options;
  options.instances.instances = instances;
  options.num_points = 60;
  return MakeSyntheticInstances(options, 5);
}

}  // namespace

TEST_CASE("a training on several structures is validated by recall, and its checkpoint finds several") {
  const TemporaryFolder folder;
  const std::string output = folder / "run";
  REQUIRE(Train(OneThread(ConfigFromYaml(kTiny, "tiny.yaml"), output), kNever) == TrainOutcome::kFinished);
  const std::string metrics = ReadFile(output + "/metrics.csv");
  CHECK(metrics.find(",recall_outliers_0.2") != std::string::npos);
  CHECK(metrics.find("mAA") == std::string::npos);
  EstimatorContext context;
  context.checkpoint_override = output + "/checkpoints/best.safetensors";
  const auto row = MakeEstimator(ConfigFromYaml("{type: diffsac}"), Task::kLine, context);
  const Example example = Lines(2)->Get(0);
  const Estimate estimate = row->Run(example.problem, 1);
  REQUIRE(estimate.status == Status::kOk);
  CHECK(estimate.instances.size() == 2);  // found by the features' hypotheses, whatever six steps have taught
}

TEST_CASE("each copy of a training item is labelled with one structure, and all structures come") {
  LabelOptions labels;
  labels.target = LabelTarget::kInstance;
  const TrainingSource source({{Lines(3), 1.0}}, PointFeatures({}, Task::kLine), {labels, 40}, {}, 1);
  const TrainingItem item = source.Make(0);
  const auto& truth = item.example->truth;
  std::set<std::int32_t> seen;
  for (const auto& label : item.labels) {
    std::set<std::int32_t> own;
    for (const int i : label) own.insert(truth.assignment[i]);
    REQUIRE(own.size() == 1);
    CHECK(label.size() ==
          static_cast<std::size_t>(std::count(truth.assignment.begin(), truth.assignment.end(), *own.begin())));
    seen.insert(*own.begin());
  }
  CHECK(seen == std::set<std::int32_t>{1, 2, 3});
}

TEST_CASE("the target distribution of several structures falls with the distance from the nearest") {
  const Example example = Lines(3)->Get(1);
  const auto distances = TruthDistances(example);
  REQUIRE(distances.size() == example.truth.assignment.size());
  std::vector<double> least(distances.size(), std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < 3; ++k) {
    const auto own = TruthDistances(OfInstance(example, k));
    for (std::size_t i = 0; i < own.size(); ++i) least[i] = std::min(least[i], own[i]);
  }
  CHECK(distances == least);
}

}  // namespace diffsac
