// Every row of the two-view tables on synthetic pairs, built from YAML by name as the programs build them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/task_dispatch.h"
#include "diffsac/problem/normalized_problem.h"
#include "diffsac/problem/tasks.h"
#include "estimate/make_estimator.h"
#include "geometry/two_view_problems.h"
#include "lab/baselines/opencv_usac.h"
#include "lab/eval/metrics.h"

namespace diffsac {
namespace {

constexpr Task kTasks[] = {Task::kHomography, Task::kFundamental, Task::kEssential};
constexpr const char* kTypes[] = {"ransac",    "lo_ransac", "prosac", "napsac",       "p_napsac",
                                  "gc_ransac", "magsac_pp", "usac",   "opencv_magsac"};

// Half of the matches are wrong; the quality orders right ones first, mostly.
Example MakePair(Task task, int num_points, std::uint64_t seed) {
  Rng rng(seed);
  const testing::TwoViewProblem random = testing::RandomProblem(num_points, rng, 0.5);
  Example example;
  example.problem.task = task;
  example.problem.inlier_threshold = 2.0;
  example.problem.points = random.pixels;
  example.problem.cameras = CameraPair{random.k1, random.k2};
  example.truth.pose = random.pose;
  example.truth.model = task == Task::kEssential ? random.essential : random.fundamental;
  if (task == Task::kHomography) {
    const Matrix3Parameters h = testing::RandomHomography(rng);
    example.problem.points = testing::HomographyPoints(h, num_points, rng, 0.5);
    example.truth.model = h;
  }
  example.problem.snn_ratio.resize(num_points);
  for (int i = 0; i < num_points; ++i) {
    const bool inlier = i % 2 == 0;
    example.truth.inliers.push_back(inlier);
    example.problem.snn_ratio[i] = inlier ? rng.Uniform(0.3, 0.9) : rng.Uniform(0.6, 1.0);
    if (inlier) continue;
    example.problem.points(i, 2) = rng.Uniform(0.0, 1000.0);
    example.problem.points(i, 3) = rng.Uniform(0.0, 800.0);
  }
  return example;
}

std::unique_ptr<RobustEstimator> Make(const std::string& type, Task task, const std::string& yaml = "{}") {
  return MakeRow(type, task, yaml);
}

TEST_CASE("Every row says how many models chance would give: few for a pair, many for images that share nothing") {
  for (const Task task : kTasks)
    for (const char* type : kTypes) {
      const auto method = Make(type, task);
      Example pair = MakePair(task, 300, 1);
      const Estimate real = method->Run(pair.problem, 1);
      REQUIRE(real.status == Status::kOk);
      CHECK(real.log10_nfa < -10.0);
      CHECK_FALSE(real.MayBeChance());
      Rng rng(2);
      for (int i = 0; i < 300; ++i)
        pair.problem.points.row(i) << rng.Uniform(0, 1000), rng.Uniform(0, 800), rng.Uniform(0, 1000),
            rng.Uniform(0, 800);
      for (const Estimate& chance :
           {method->Run(pair.problem, 1),
            method->RunBatch(std::vector<const Problem*>{&pair.problem}, std::vector<std::uint64_t>{1})[0]}) {
        CAPTURE(ToString(task), type, chance.inliers.size());
        if (chance.status == Status::kOk) CHECK(chance.MayBeChance());
      }
    }
}

TEST_CASE("The noise of the inliers is told in pixels, whichever space was searched and however it is estimated") {
  for (const Task task : kTasks)
    for (const char* consensus : {"{}", "{threshold: adaptive, least_scale: .25, greatest_scale: 4}"}) {
      const auto method = Make("lo_ransac", task, std::string("{max_iterations: 300, consensus: ") + consensus + "}");
      double sum = 0.0;
      for (std::uint64_t seed = 0; seed < 8; ++seed) sum += method->Run(MakePair(task, 400, seed).problem, 1).sigma;
      INFO(ToString(task) << " " << consensus);
      // Of .5 px a coordinate; each of the two of a homography's residual is of both images.
      CHECK(sum / 8 == Approx(task == Task::kHomography ? 0.707 : 0.5).epsilon(0.25));
    }
}

TEST_CASE("Every two-view row finds H, F and E among half outliers") {
  for (Task task : kTasks)
    for (const char* type : kTypes) {
      const auto method = Make(type, task);
      REQUIRE(method);
      int good = 0;
      for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const Example example = MakePair(task, 200, seed);
        const Estimate estimate = method->Run(example.problem, seed);
        const EstimateError error = MeasureError(estimate, example);
        good += task == Task::kHomography ? error.error_px < 5.0 : error.angle_deg < 5.0;
        CHECK(estimate.stats.hypotheses > 0);
      }
      CAPTURE(ToString(task), type, good);
      CHECK(good >= 8);
    }
}

TEST_CASE("The mask of a two-view row is the residuals' in the space it was solved in, less what is behind a camera") {
  for (Task task : kTasks)
    for (const char* type : kTypes) {
      const Example example = MakePair(task, 150, 77);
      const Estimate estimate = Make(type, task)->Run(example.problem, 1);
      REQUIRE(estimate.status == Status::kOk);
      const NormalizedProblem space(example.problem);
      const auto mask = DispatchTask(task, [&]<MinimalModel Model>() {
        return InlierMask<Model>(space.points(), typename Model::Parameters(estimate.model), space.threshold());
      });
      CAPTURE(ToString(task), type);
      const auto fitting = std::count(mask.begin(), mask.end(), 1);
      int beside = 0;
      for (std::size_t i = 0; i < mask.size(); ++i) beside += estimate.inliers[i] > mask[i];
      CHECK(beside == 0);
      CHECK(fitting - std::count(estimate.inliers.begin(), estimate.inliers.end(), 1) ==
            std::lround(estimate.cheirality_failure_ratio * static_cast<double>(fitting)));
      CHECK((task == Task::kEssential || estimate.cheirality_failure_ratio == 0.0));
    }
}

TEST_CASE("Two-view rows repeat themselves, another seed may differ") {
  for (const char* type : {"ransac", "prosac", "p_napsac", "gc_ransac", "magsac_pp"}) {
    const Example example = MakePair(Task::kFundamental, 150, 5);
    const Estimate a = Make(type, Task::kFundamental)->Run(example.problem, 3);
    const Estimate b = Make(type, Task::kFundamental)->Run(example.problem, 3);
    CAPTURE(type);
    CHECK(a.model == b.model);
    CHECK(a.inliers == b.inliers);
  }
}

TEST_CASE("Two-view rows answer hostile input with a status") {
  for (Task task : kTasks)
    for (const char* type : kTypes) {
      CAPTURE(ToString(task), type);
      const auto method = Make(type, task);
      const Example whole = MakePair(task, 40, 9);
      for (int count : {0, 1, MinimalSetSize(task) - 1}) {
        Problem problem = whole.problem;
        problem.points = whole.problem.points.topRows(count).eval();
        problem.snn_ratio = whole.problem.snn_ratio.head(count).eval();
        CHECK(method->Run(problem, 1).status == Status::kTooFewPoints);
      }
      Problem equal = whole.problem;
      equal.points.rowwise() = whole.problem.points.row(0);
      CHECK(method->Run(equal, 1).status == Status::kDegenerate);
      Problem invalid = whole.problem;
      invalid.points(3, 2) = std::numeric_limits<double>::quiet_NaN();
      CHECK(method->Run(invalid, 1).num_nonfinite == 1);
      invalid.points.col(2).setConstant(std::numeric_limits<double>::quiet_NaN());
      CHECK(method->Run(invalid, 1).status == Status::kTooFewPoints);
    }
  Problem uncalibrated = MakePair(Task::kEssential, 40, 9).problem;
  uncalibrated.cameras.reset();
  CHECK(Make("ransac", Task::kEssential)->Run(uncalibrated, 1).status == Status::kDegenerate);
}

TEST_CASE("regression: OpenCV's graph cut crashed with 100 000 matches") {
  const Problem problem = MakePair(Task::kFundamental, 50000, 4).problem;
  const auto accurate = Make("usac", Task::kFundamental, "preset: accurate");
  CHECK(accurate->Run(problem, 1).status == Status::kTooManyPoints);
  CHECK(Make("usac", Task::kFundamental)->Run(problem, 1).status == Status::kOk);
}

TEST_CASE("PROSAC without a quality samples uniformly instead of failing") {
  Example example = MakePair(Task::kFundamental, 150, 11);
  example.problem.snn_ratio.resize(0);
  CHECK(Make("prosac", Task::kFundamental)->Run(example.problem, 1).status == Status::kOk);
}

TEST_CASE("Rows that are for one view are refused for two and the other way round") {
  for (const char* type : {"theil_sen", "exhaustive"}) CHECK_THROWS_AS(Make(type, Task::kFundamental), Error);
  for (const char* type : {"usac", "opencv_magsac"}) CHECK_THROWS_AS(Make(type, Task::kLine), Error);
  CHECK_THROWS_AS(Make("usac", Task::kHomography, "preset: best"), Error);
  CHECK_THROWS_AS(Make("prosac", Task::kHomography, "sampling: {sourse: prosac}"), Error);
}

}  // namespace
}  // namespace diffsac
