#include "lab/torch/weighted_estimator.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>

#include <limits>

#include "diffsac/problem/tasks.h"
#include "estimate/tiny_network.h"
#include "lab/data/synthetic_two_view.h"
#include "lab/torch/clnet.h"
#include "lab/torch/ng_ransac.h"

namespace diffsac {
namespace {

constexpr Task kTasks[] = {Task::kLine, Task::kPlane, Task::kHomography, Task::kFundamental, Task::kEssential};

PointFeaturesOptions Features() {
  PointFeaturesOptions features;
  features.kinds = {PointFeature::kCoordinates};
  return features;
}

std::shared_ptr<LearnedWeights> Network(const std::string& method, Task task) {
  if (method == "clnet") {
    ClnetNetworkOptions options;
    options.features = Features();
    options.width = 8;
    return MakeLearnedWeights<ClnetNetwork>(task, options, Rng(1));
  }
  NgRansacNetworkOptions options;
  options.features = Features();
  options.width = 8;
  options.blocks = 2;
  return MakeLearnedWeights<NgRansacNetwork>(task, options, Rng(1));
}

std::vector<Example> ExamplesOf(Task task, int count) {
  if (!IsTwoView(task)) return TinyExamples(task, count, 0.5);
  SyntheticTwoViewOptions options;
  options.task = task;
  options.matches.num_points = {60, 90};
  options.matches.outlier_ratio = {0.5, 0.5};
  options.matches.noise_px = 0.2;
  options.matches.displaced_share = 0.0;
  options.mixed = options.forward = 0.0;  // scenes that the linear fits determine
  options.general = task == Task::kHomography ? 0.0 : 1.0;
  options.planar = task == Task::kHomography ? 1.0 : 0.0;
  options.baseline = {0.2, 0.6};
  options.depth_ratio = {4.0, 10.0};
  options.split = "test";
  const auto dataset = MakeSyntheticTwoView(options, 3);
  std::vector<Example> examples;
  for (int i = 0; i < count; ++i) examples.push_back(dataset->Get(i));
  return examples;
}

// As of a perfect network.
Prediction Perfect(const Example& example) {
  Prediction prediction;
  for (const auto inlier : example.truth.inliers) prediction.weights.push_back(inlier ? 1.0f : 0.0f);
  return prediction;
}

}  // namespace

TEST_CASE("weights of the true inliers give the true model, by sets and by one weighted fit") {
  for (const std::string type : {"ng_ransac", "clnet"})
    for (const Task task : kTasks) {
      CAPTURE(type, ToString(task));
      auto options = DefaultWeightedOptions(type);
      options.consensus.score = options.consensus.final_score = ScoreKind::kMsac;
      options.consensus.final_refinement = IsTwoView(task) ? FinalRefinement::kRefinement : FinalRefinement::kNone;
      const WeightedEstimator method(Network(type, task), options, 1);
      int good = 0;
      for (const auto& example : ExamplesOf(task, 8)) {
        const auto prediction = Perfect(example);
        const auto estimate = method.EstimateFrom(NormalizedProblem(example.problem), prediction, 5);
        REQUIRE(estimate.status == Status::kOk);
        int found = 0, wrong = 0, total = 0;
        for (std::size_t i = 0; i < estimate.inliers.size(); ++i) {
          (example.truth.inliers[i] ? found : wrong) += estimate.inliers[i];
          total += example.truth.inliers[i];
        }
        good += 2 * found > total && found > 3 * wrong;
        if (type == "clnet") CHECK(estimate.minimal_sets.empty());
        for (const auto& set : estimate.minimal_sets)
          for (const int i : set) CHECK(example.truth.inliers[i] == 1);
        CHECK(method.EstimateFrom(NormalizedProblem(example.problem), prediction, 5).model == estimate.model);
      }
      CHECK(good >= 7);
    }
}

TEST_CASE("a batch of learned weights gives what single calls give, budgets are counted") {
  for (const std::string type : {"ng_ransac", "clnet"})
    for (const Task task : {Task::kLine, Task::kEssential}) {
      auto options = DefaultWeightedOptions(type);
      options.consensus.refit = Refit::kNone;
      const WeightedEstimator method(Network(type, task), options, 1);
      std::vector<Problem> problems;
      std::vector<std::uint64_t> seeds;
      for (const auto& example : ExamplesOf(task, 4)) {
        problems.push_back(example.problem);
        seeds.push_back(example.index + 100);
      }
      const auto together = method.RunBatch(PointersTo(problems), seeds);
      for (std::size_t i = 0; i < problems.size(); ++i) {
        const auto alone = method.Run(problems[i], seeds[i]);
        REQUIRE(together[i].status == alone.status);
        CHECK(together[i].stats.hypotheses == alone.stats.hypotheses);
        CHECK(alone.stats.hypotheses >= options.max_iterations + (options.weighted_fit ? 1 : 0));
      }
    }
}

TEST_CASE("bad points give a status to rows of learned weights, alone and beside good ones") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::string type : {"ng_ransac", "clnet"})
    for (const Task task : {Task::kLine, Task::kHomography, Task::kEssential}) {
      CAPTURE(type, ToString(task));
      const WeightedEstimator method(Network(type, task), DefaultWeightedOptions(type), 1);
      const Problem good = ExamplesOf(task, 1)[0].problem;
      std::vector<Problem> bad(5, good);
      bad[0].points.resize(0, good.points.cols());
      bad[1].points = PointMatrix(good.points.topRows(MinimalSetSize(task) - 1));
      bad[2].points.rowwise() = good.points.row(0).eval();
      bad[3].points.col(1).setConstant(nan);
      bad[4].points = PointMatrix(good.points.topRows(MinimalSetSize(task)));  // enough for a set, not for every fit
      for (auto& problem : bad) problem.snn_ratio.resize(0);
      for (int i = 0; i < 4; ++i) CHECK(method.Run(bad[i], 1).status != Status::kOk);
      method.Run(bad[4], 1);
      for (const double scale : {1e-8, 1e8}) {
        Problem scaled = good;
        scaled.points *= scale;
        scaled.inlier_threshold *= scale;
        method.Run(scaled, 1);  // any status
      }
      const std::vector<Problem> mixed = {bad[3], good, bad[1]};
      const std::vector<std::uint64_t> seeds = {1, 2, 3};
      const auto estimates = method.RunBatch(PointersTo(mixed), seeds);
      CHECK(estimates[0].status != Status::kOk);
      CHECK(estimates[1].status == method.Run(good, 2).status);
      CHECK(estimates[2].status == Status::kTooFewPoints);
    }
}

TEST_CASE("regression: a million points asked for four terabytes in CLNet's graph") {
  const WeightedEstimator method(Network("clnet", Task::kLine), DefaultWeightedOptions("clnet"), 1);
  const Problem good = ExamplesOf(Task::kLine, 1)[0].problem;
  Problem large = good;
  large.points = PointMatrix::Random(ClnetNetwork::kMostPoints + 1, 2);
  CHECK(method.Run(large, 1).status == Status::kTooManyPoints);
  const std::vector<Problem> mixed = {large, good};
  const std::vector<std::uint64_t> seeds = {1, 2};
  const auto estimates = method.RunBatch(PointersTo(mixed), seeds);
  CHECK(estimates[0].status == Status::kTooManyPoints);
  CHECK(estimates[1].status == method.Run(good, 2).status);
}

}  // namespace diffsac
