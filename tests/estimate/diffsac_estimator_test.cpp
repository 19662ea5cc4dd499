#include <torch/torch.h>

#include "diffsac/estimate/diffsac_estimator.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <set>

#include "diffsac/geometry/hyperplane.h"
#include "diffsac/problem/tasks.h"
#include "estimate/tiny_network.h"

namespace diffsac {
namespace {

DiffsacOptions FewSteps() {
  DiffsacOptions options;
  options.num_diffusion_samples = 6;
  options.sampler.steps = 3;
  options.batch = 4;
  return options;
}

Problem PointsOf(std::initializer_list<std::pair<double, double>> values) {
  Problem problem;
  problem.points.resize(static_cast<Eigen::Index>(values.size()), 2);
  int row = 0;
  for (const auto& [x, y] : values) problem.points.row(row++) << x, y;
  return problem;
}

struct Batch {
  std::vector<Problem> problems;
  std::vector<std::uint64_t> seeds;
  explicit Batch(const std::vector<Example>& examples) {
    for (const auto& example : examples) {
      problems.push_back(example.problem);
      seeds.push_back(example.index + 100);
    }
  }
};

}  // namespace

TEST_CASE("a batch gives what single calls give, for ragged problems") {
  for (const Task task : {Task::kLine, Task::kPlane}) {
    const DiffsacEstimator method(TinyNetwork(task), FewSteps(), 1);
    const Batch batch(TinyExamples(task, 7));
    const auto together = method.RunBatch(PointersTo(batch.problems), batch.seeds);
    for (std::size_t i = 0; i < batch.problems.size(); ++i) {
      const auto alone = method.Run(batch.problems[i], batch.seeds[i]);
      REQUIRE(together[i].status == Status::kOk);
      // The network's outputs agree to rounding only, the consensus is exact on them.
      CHECK(AngleBetweenDegrees(together[i].model, alone.model) < 1e-4);
      CHECK(together[i].stats.unique_minimal_sets == alone.stats.unique_minimal_sets);
    }
  }
}

TEST_CASE("the same confidences give the same estimate bit for bit with 1 and 2 threads") {
  const auto network = TinyNetwork(Task::kLine);
  const DiffsacEstimator one(network, FewSteps(), 1), two(network, FewSteps(), 2);
  const auto example = TinyExamples(Task::kLine, 1)[0];
  const int points = static_cast<int>(example.problem.points.rows());
  Prediction prediction;
  Rng rng(3);
  for (int i = 0; i < 6 * points; ++i) prediction.confidences.push_back(static_cast<float>(rng.Normal()));
  const NormalizedProblem space(example.problem);
  const auto a = one.EstimateFrom(space, prediction, 9), b = two.EstimateFrom(space, prediction, 9);
  REQUIRE(a.status == Status::kOk);
  CHECK(a.model == b.model);
  CHECK(a.inliers == b.inliers);
  CHECK(a.score == b.score);
}

TEST_CASE("threads do not change a batch, seeds do") {
  const auto network = TinyNetwork(Task::kLine);
  const DiffsacEstimator one(network, FewSteps(), 1), two(network, FewSteps(), 2);
  Batch batch(TinyExamples(Task::kLine, 5));
  const auto a = one.RunBatch(PointersTo(batch.problems), batch.seeds),
             b = two.RunBatch(PointersTo(batch.problems), batch.seeds);
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i].model == b[i].model);
  for (auto& seed : batch.seeds) seed += 1000;
  const auto c = one.RunBatch(PointersTo(batch.problems), batch.seeds);
  bool differs = false;
  for (std::size_t i = 0; i < a.size(); ++i) differs = differs || a[i].model != c[i].model;
  CHECK(differs);
}

TEST_CASE("bad points give a status, alone and beside good ones") {
  const DiffsacEstimator method(TinyNetwork(Task::kLine), FewSteps(), 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Problem empty;
  empty.points.resize(0, 2);
  CHECK(method.Run(empty, 1).status == Status::kTooFewPoints);
  CHECK(method.Run(PointsOf({{1, 2}}), 1).status == Status::kTooFewPoints);
  CHECK(method.Run(PointsOf({{1, 2}, {1, 2}, {1, 2}}), 1).status == Status::kDegenerate);
  const auto left = method.Run(PointsOf({{1, 2}, {2, nan}, {3, 4}}), 1);
  CHECK(left.status == Status::kOk);
  CHECK(left.inliers == std::vector<std::uint8_t>{1, 0, 1});
  const auto two = method.Run(PointsOf({{0, 0}, {1, 1}}), 1);
  REQUIRE(two.status == Status::kOk);
  CHECK(std::abs(two.model[0] + two.model[1]) < 1e-9);

  const auto good = TinyExamples(Task::kLine, 1)[0].problem;
  Problem repeated = good;
  repeated.points = good.points.replicate(2, 1);
  repeated.points.row(0).setConstant(nan);
  const std::vector<Problem> mixed = {PointsOf({{1, 2}}), good, PointsOf({{nan, 2}, {2, 3}}), repeated};
  const std::vector<std::uint64_t> seeds = {1, 2, 3, 4};
  const auto estimates = method.RunBatch(PointersTo(mixed), seeds);
  CHECK(estimates[0].status == Status::kTooFewPoints);
  CHECK(estimates[1].status == Status::kOk);
  CHECK(estimates[2].status == Status::kTooFewPoints);
  CHECK(estimates[2].inliers == std::vector<std::uint8_t>{0, 0});
  const Estimate alone = method.Run(repeated, 4);
  CHECK(estimates[3].inliers == alone.inliers);
  CHECK(estimates[3].inliers.size() == static_cast<std::size_t>(repeated.points.rows()));
  CHECK(estimates[3].inlier_probabilities.size() == estimates[3].inliers.size());
  CHECK(estimates[3].num_nonfinite == 1);
  CHECK(estimates[3].num_duplicates == good.points.rows() - 1);
  CHECK(AngleBetweenDegrees(estimates[1].model, method.Run(good, 2).model) < 1e-4);
}

TEST_CASE("the budget counts the features' hypotheses, the κ sets and every refit") {
  auto options = FewSteps();
  options.consensus.refit = Refit::kNone;
  const auto problem = TinyExamples(Task::kLine, 1)[0].problem;
  CHECK(DiffsacEstimator(TinyNetwork(Task::kLine), options, 1).Run(problem, 1).stats.hypotheses == 30 + 6);
  options.weighted_fit = true;
  CHECK(DiffsacEstimator(TinyNetwork(Task::kLine), options, 1).Run(problem, 1).stats.hypotheses == 30 + 6 + 1);
  options.residual_draws = 50;
  CHECK(DiffsacEstimator(TinyNetwork(Task::kLine), options, 1).Run(problem, 1).stats.hypotheses == 50 + 6 + 1);
  options.residual_draws = 0;
  options.feature_hypotheses = true;
  CHECK(DiffsacEstimator(TinyNetwork(Task::kLine), options, 1).Run(problem, 1).stats.hypotheses == 30 + 6 + 1);
}

TEST_CASE("unique sets are unique") {
  auto options = FewSteps();
  options.num_diffusion_samples = 20;
  const auto problem = TinyExamples(Task::kPlane, 1)[0].problem;
  CHECK(DiffsacEstimator(TinyNetwork(Task::kPlane), options, 1).Run(problem, 1).stats.unique_minimal_sets == 20);
}

TEST_CASE("decoding only likely points takes minimal sets from them alone") {
  auto options = FewSteps();
  options.max_decoded_points = 8;
  options.num_diffusion_samples = 12;
  const auto problem = TinyExamples(Task::kLine, 1)[0].problem;
  const DiffsacEstimator method(TinyNetwork(Task::kLine), options, 1);
  const auto steps = method.Trace(problem, 1).value();
  const std::size_t points = problem.points.rows();
  std::set<std::size_t> decoded;
  for (const auto& step : steps.confidences)
    for (std::size_t i = 0; i < step.size(); ++i)
      if (std::isfinite(step[i])) decoded.insert(i % points);
  CHECK(decoded.size() == 8);
  CHECK(method.Run(problem, 1).status == Status::kOk);
}

TEST_CASE("a trace has one entry a network call") {
  const DiffsacEstimator method(TinyNetwork(Task::kLine), FewSteps(), 1);
  const auto problem = TinyExamples(Task::kLine, 1)[0].problem;
  const auto steps = method.Trace(problem, 1).value();
  CHECK(steps.num_diffusion_samples == 6);
  CHECK(steps.timesteps.size() == 3);
  REQUIRE(steps.confidences.size() == 3);
  CHECK(steps.confidences[0].size() == 6 * static_cast<std::size_t>(problem.points.rows()));
  CHECK(steps.timesteps[0] > steps.timesteps[2]);
  CHECK_FALSE(method.Trace(PointsOf({{1, 2}}), 1));
  // A row that draws from the inlier head takes no step (its pictures showed one).
  auto drawn = FewSteps();
  drawn.num_diffusion_samples = 0;
  drawn.num_guided_samples = 6;
  drawn.selection = SetSelection::kGumbel;
  CHECK_FALSE(DiffsacEstimator(TinyNetwork(Task::kLine), drawn, 1).Trace(problem, 1));
}

TEST_CASE("options that need the inlier head say so") {
  auto network_options = TinyOptions();
  network_options.denoiser.inlier_head = false;
  auto options = FewSteps();
  options.weighted_fit = true;
  CHECK_THROWS_WITH(DiffsacEstimator(TinyNetwork(Task::kLine, network_options), options, 1),
                    Catch::Contains("inlier_head"));
}

}  // namespace diffsac
