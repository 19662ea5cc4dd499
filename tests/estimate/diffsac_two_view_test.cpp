#include <catch2/catch.hpp>

#include <algorithm>
#include <numeric>
#include <set>

#include "diffsac/core/range.h"
#include "diffsac/problem/tasks.h"
#include "estimate/tiny_network.h"
#include "lab/data/synthetic_two_view.h"

namespace diffsac {
namespace {

NetworkOptions TwoViewNetwork() {
  auto options = TinyOptions();
  options.features.kinds = {PointFeature::kRatio};
  return options;
}

std::vector<Example> TwoViewExamples(Task task, int count) {
  SyntheticTwoViewOptions options;
  options.task = task;
  options.matches.num_points = {60, 90};
  options.matches.outlier_ratio = {0.3, 0.3};
  options.split = "test";
  const auto dataset = MakeSyntheticTwoView(options, 3);
  std::vector<Example> examples;
  for (int i = 0; i < count; ++i) examples.push_back(dataset->Get(i));
  return examples;
}

DiffsacOptions Options(int copies) {
  DiffsacOptions options;
  options.num_diffusion_samples = copies;
  options.sampler.steps = 2;
  options.consensus.score = options.consensus.final_score = ScoreKind::kMsac;
  options.consensus.local_optimization = LocalOptimization::kInnerSamples;
  return options;
}

// Confidences as of a perfect network: true inliers near +1, others near −1, a little noise to tell copies apart.
Prediction Perfect(const Example& example, int copies) {
  Prediction prediction;
  Rng rng(4);
  for (int k = 0; k < copies; ++k)
    for (const auto inlier : example.truth.inliers)
      prediction.confidences.push_back((inlier ? 0.8f : -0.8f) + 0.1f * static_cast<float>(rng.Uniform(-1.0, 1.0)));
  for (const auto inlier : example.truth.inliers) prediction.weights.push_back(inlier ? 0.9f : 0.1f);
  return prediction;
}

}  // namespace

TEST_CASE("confident sets of true inliers give the true two-view model") {
  for (const Task task : {Task::kHomography, Task::kFundamental, Task::kEssential}) {
    for (const auto selection : {SetSelection::kMaximum, SetSelection::kProbabilistic, SetSelection::kGumbel}) {
      auto options = Options(40);
      options.selection = selection;
      options.temperature = 0.2;
      const DiffsacEstimator method(TinyNetwork(task, TwoViewNetwork()), options, 1);
      int good = 0;
      const auto examples = TwoViewExamples(task, 8);
      for (const auto& example : examples) {
        const auto estimate = method.EstimateFrom(NormalizedProblem(example.problem), Perfect(example, 40), 5);
        REQUIRE(estimate.status == Status::kOk);
        int found = 0, wrong = 0;
        for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
          (example.truth.inliers[i] ? found : wrong) += estimate.inliers[i];
        good += found > 5 * wrong && found > 10;
      }
      CHECK(good >= 7);
    }
  }
}

TEST_CASE("an untrained two-view network gives an estimate, batched as alone") {
  for (const Task task : {Task::kHomography, Task::kFundamental, Task::kEssential}) {
    const DiffsacEstimator method(TinyNetwork(task, TwoViewNetwork()), Options(6), 1);
    std::vector<Problem> problems;
    std::vector<std::uint64_t> seeds;
    for (const auto& example : TwoViewExamples(task, 4)) {
      problems.push_back(example.problem);
      seeds.push_back(example.index);
    }
    problems.push_back(problems[0]);
    problems.back().points.conservativeResize(3, 4);
    seeds.push_back(1);
    const auto together = method.RunBatch(PointersTo(problems), seeds);
    for (std::size_t i = 0; i + 1 < problems.size(); ++i) {
      CHECK(together[i].stats.unique_minimal_sets == 6);
      CHECK(together[i].status == method.Run(problems[i], seeds[i]).status);
    }
    CHECK(together.back().status == Status::kTooFewPoints);
  }
}

TEST_CASE("a network that reads similarities sees them where a problem has them, and does without where it has none") {
  NetworkOptions network = TwoViewNetwork();
  network.features.kinds = {PointFeature::kRatio, PointFeature::kNeighborhood, PointFeature::kSimilarity};
  for (const Task task : {Task::kHomography, Task::kFundamental, Task::kEssential}) {
    const DiffsacEstimator method(TinyNetwork(task, network), Options(6), 1);
    Problem problem = TwoViewExamples(task, 1)[0].problem;
    const auto without = method.Run(problem, 3);
    CHECK(without.stats.unique_minimal_sets == 6);
    problem.scale_rotation_changes.resize(problem.points.rows(), 2);
    Rng rng(5);
    for (double& value : problem.scale_rotation_changes.reshaped()) value = rng.Uniform(-1.0, 1.0);
    const auto with = method.Run(problem, 3);
    REQUIRE(with.inlier_probabilities.size() == without.inlier_probabilities.size());
    CHECK(with.inlier_probabilities != without.inlier_probabilities);
    // Matches in another order have theirs.
    const auto order = Rng(6).Permutation(static_cast<int>(problem.points.rows()));
    Problem permuted = problem;
    permuted.points = problem.points(order, Eigen::all);
    permuted.snn_ratio = problem.snn_ratio(order);
    permuted.scale_rotation_changes = problem.scale_rotation_changes(order, Eigen::all);
    const auto again = method.Run(permuted, 3);
    for (std::size_t i = 0; i < order.size(); ++i)
      CHECK(again.inlier_probabilities[i] == Approx(with.inlier_probabilities[order[i]]).margin(1e-4));
  }
}

TEST_CASE("the reported sets are those that are solved") {
  for (const Task task : {Task::kHomography, Task::kFundamental, Task::kEssential}) {
    const auto example = TwoViewExamples(task, 1)[0];
    const DiffsacEstimator method(TinyNetwork(task, TwoViewNetwork()), Options(6), 1);
    const auto estimate = method.Run(example.problem, 8);
    REQUIRE(estimate.minimal_sets.size() == 6);
    for (const auto& set : estimate.minimal_sets) {
      REQUIRE(static_cast<int>(set.size()) == MinimalSetSize(task));
      CHECK(std::is_sorted(set.begin(), set.end()));
      CHECK(set.back() < example.problem.points.rows());
    }
    const std::set<std::vector<int>> distinct(estimate.minimal_sets.begin(), estimate.minimal_sets.end());
    CHECK(static_cast<int>(distinct.size()) == estimate.stats.unique_minimal_sets);
    CHECK(estimate.minimal_sets == method.Run(example.problem, 8).minimal_sets);
    Problem empty = example.problem;
    empty.points.conservativeResize(0, 4);
    CHECK(method.Run(empty, 8).minimal_sets.empty());
  }
}

TEST_CASE("temperatures rise from the first copy to the last") {
  const auto example = TwoViewExamples(Task::kFundamental, 1)[0];
  const std::size_t points = example.truth.inliers.size();
  auto options = Options(20);
  options.selection = SetSelection::kGumbel;
  options.temperature = Range(1e-4, 100.0);
  options.unique_sets = false;
  // The same confidences for all copies, falling with the index.
  Prediction prediction;
  for (int k = 0; k < 20; ++k)
    for (std::size_t i = 0; i < points; ++i)
      prediction.confidences.push_back(0.9f - 1.8f * static_cast<float>(i) / points);
  prediction.weights.assign(points, 0.5f);
  const DiffsacEstimator method(TinyNetwork(Task::kFundamental, TwoViewNetwork()), options, 1);
  const auto sets = method.EstimateFrom(NormalizedProblem(example.problem), prediction, 5).minimal_sets;
  REQUIRE(sets.size() == 20);
  const auto mean = [](const std::vector<int>& set) {
    return std::accumulate(set.begin(), set.end(), 0.0) / static_cast<double>(set.size());
  };
  CHECK(sets[0] == std::vector<int>{0, 1, 2, 3, 4, 5, 6});
  double late = 0.0;
  for (int k = 15; k < 20; ++k) late += mean(sets[k]) / 5.0;
  CHECK(late > 0.3 * static_cast<double>(points));
}

TEST_CASE("the inlier head guides without the reverse process, extra sets are counted, 8-point sets are solved") {
  const auto example = TwoViewExamples(Task::kFundamental, 1)[0];
  auto options = Options(10);
  options.num_diffusion_samples = 0;
  options.num_guided_samples = 10;
  options.selection = SetSelection::kGumbel;
  const auto network = TinyNetwork(Task::kFundamental, TwoViewNetwork());
  CHECK(DiffsacEstimator(network, options, 1).Run(example.problem, 2).minimal_sets.size() == 10);
  for (const auto source : {MinimalSamplerKind::kUniform, MinimalSamplerKind::kProsac}) {
    options.num_uniform_samples = 15;
    options.extra_sampler = source;
    CHECK(DiffsacEstimator(network, options, 1).Run(example.problem, 2).stats.unique_minimal_sets > 15);
  }
  options.num_uniform_samples = 0;
  options.model = "fundamental8";
  const DiffsacEstimator eight(network, options, 1);
  const auto estimate = eight.EstimateFrom(NormalizedProblem(example.problem), Perfect(example, 10), 5);
  CHECK(estimate.status == Status::kOk);
  Problem seven = example.problem;
  seven.points.conservativeResize(7, 4);
  seven.snn_ratio.conservativeResize(7);
  CHECK(eight.Run(seven, 1).status == Status::kTooFewPoints);
  CHECK(DiffsacEstimator(network, Options(10), 1).Run(seven, 1).status != Status::kTooFewPoints);

  auto no_head = TwoViewNetwork();
  no_head.denoiser.inlier_head = false;
  CHECK_THROWS_WITH(DiffsacEstimator(TinyNetwork(Task::kFundamental, no_head), options, 1),
                    Catch::Contains("num_guided_samples"));
}

}  // namespace diffsac
