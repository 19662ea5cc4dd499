// The row `dgsac` as tables build it: by name, for every task.
#include <catch2/catch.hpp>
#include <limits>
#include <type_traits>

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/estimate/task_dispatch.h"
#include "diffsac/problem/normalized_problem.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "ransac/all_models.h"

namespace diffsac {
namespace {

constexpr Task kTasks[] = {Task::kLine, Task::kPlane, Task::kHomography, Task::kFundamental, Task::kEssential};

std::unique_ptr<RobustEstimator> Make(const std::string& yaml, Task task) {
  return MakeEstimator(ConfigFromYaml(yaml, "t.yaml"), task, {"", "cpu", 1});
}

/// 160 points, 40 % of them outliers, those first.
Problem MakeProblem(Task task, std::uint64_t seed) {
  Problem problem;
  problem.task = task;
  if (task == Task::kEssential) {
    Rng rng(seed);
    testing::TwoViewProblem views = testing::RandomProblem(160, rng, 0.5);
    for (int i = 0; i < 64; ++i)
      for (int j = 0; j < 4; ++j) views.pixels(i, j) = rng.Uniform(0.0, 1000.0);
    problem.points = views.pixels;
    problem.cameras = CameraPair{views.k1, views.k2};
    problem.inlier_threshold = 2.0;
    return problem;
  }
  DispatchTask(task, [&]<MinimalModel Model>() {
    const testing::ModelProblem model = testing::MakeModelProblem<Model>(160, 0.4, Rng(seed));
    problem.points = model.points;
    problem.inlier_threshold = model.threshold;
    return 0;
  });
  return problem;
}

TEST_CASE("dgsac is a row of every task, with and without the other rows' refits") {
  for (Task task : kTasks)
    for (const char* finish : {"density", "consensus"}) {
      const auto method = Make("{type: dgsac, max_iterations: 600, finish: " + std::string(finish) + "}", task);
      int good = 0;
      for (std::uint64_t seed = 0; seed < 5; ++seed) {
        const Problem problem = MakeProblem(task, seed);
        const Estimate estimate = method->Run(problem, seed);
        REQUIRE(estimate.status == Status::kOk);
        REQUIRE(estimate.model.size() == (IsTwoView(task) ? 9 : PointDimension(task) + 1));
        int inliers = 0, wrong = 0;
        for (int i = 0; i < 160; ++i) (i < 64 ? wrong : inliers) += estimate.inliers[i];
        good += inliers >= 80 && wrong <= 16 ? 1 : 0;
        CHECK(estimate.stats.hypotheses > 0);
        CHECK(estimate.stats.unique_minimal_sets <= 600);
        CHECK(estimate.stats.ms_total >= 0.0);
        CHECK(estimate.minimal_sets.size() == 20);
      }
      CAPTURE(ToString(task), finish, good);
      CHECK(good >= 4);
    }
}

TEST_CASE("dgsac's mask is at the threshold, its model is not") {
  for (Task task : kTasks) {
    Problem problem = MakeProblem(task, 3);
    const auto method = Make("{type: dgsac, max_iterations: 200}", task);
    const Estimate estimate = method->Run(problem, 1);
    REQUIRE(estimate.status == Status::kOk);
    const NormalizedProblem space(problem);
    const auto mask = DispatchTask(task, [&]<MinimalModel Model>() {
      return InlierMask<Model>(space.points(), typename Model::Parameters(estimate.model), space.threshold());
    });
    CAPTURE(ToString(task));
    CHECK(estimate.inliers == mask);
    problem.inlier_threshold *= 100.0;
    CHECK(method->Run(problem, 1).model == estimate.model);
    CHECK(method->Run(problem, 1).inliers != estimate.inliers);
  }
}

TEST_CASE("dgsac repeats itself") {
  const Problem problem = MakeProblem(Task::kFundamental, 7);
  const auto method = Make("{type: dgsac, max_iterations: 200, finish: consensus}", Task::kFundamental);
  CHECK(method->Run(problem, 2).model == method->Run(problem, 2).model);
  CHECK(method->Run(problem, 2).minimal_sets != method->Run(problem, 3).minimal_sets);
}

TEST_CASE("dgsac's wrong options are errors with the place") {
  CHECK_THROWS_WITH(Make("{type: dgsac, max_iteration: 3}", Task::kLine), Catch::Contains("max_iterations"));
  CHECK_THROWS_WITH(Make("{type: dgsac, stopping: never}", Task::kLine), Catch::Contains("t.yaml:1"));
  CHECK_THROWS_WITH(Make("{type: dgsac, max_iterations: 0}", Task::kLine), Catch::Contains("max_iterations"));
  CHECK_THROWS_WITH(Make("{type: dgsca}", Task::kLine), Catch::Contains("did you mean 'dgsac'"));
}

TEST_CASE("dgsac answers hostile input with a status") {
  for (Task task : kTasks) {
    CAPTURE(ToString(task));
    const auto method = Make("{type: dgsac, max_iterations: 30}", task);
    const Problem whole = MakeProblem(task, 9);
    for (int count : {0, 1, MinimalSetSize(task) - 1}) {
      Problem problem = whole;
      problem.points = whole.points.topRows(count).eval();
      CHECK(method->Run(problem, 1).status == Status::kTooFewPoints);
    }
    Problem equal = whole;
    equal.points.rowwise() = Eigen::RowVectorXd(whole.points.row(0));
    CHECK(method->Run(equal, 1).status == Status::kDegenerate);
    Problem invalid = whole;
    invalid.points(3, 1) = std::numeric_limits<double>::quiet_NaN();
    CHECK(method->Run(invalid, 1).num_nonfinite == 1);
  }
}

}  // namespace
}  // namespace diffsac
