#include "diffsac/report/pair_text.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "diffsac/core/random.h"
#include "diffsac/problem/pair_truth.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using Catch::Contains;

struct Answered {
  Example pair;
  Estimate estimate;
};

// Twelve outliers and the others right, with the true model as the estimate.
Answered AnsweredPair(Task task, int points) {
  Rng rng(4);
  const testing::TwoViewProblem random = testing::RandomProblem(points, rng, 0.0);
  Answered answered;
  answered.pair.id = "a-b";
  Problem& problem = answered.pair.problem;
  problem.task = task;
  problem.points = random.pixels;
  problem.inlier_threshold = 1.0;
  problem.size1 = problem.size2 = {1000, 800};
  if (task == TaskFromString("essential")) problem.cameras = CameraPair{random.k1, random.k2};
  answered.estimate.status = Status::kOk;
  answered.estimate.model = problem.cameras ? ModelParameters(random.essential) : ModelParameters(random.fundamental);
  answered.estimate.inliers.assign(static_cast<std::size_t>(points), 1);
  std::fill_n(answered.estimate.inliers.begin(), 12, 0);
  answered.estimate.noise_scale = 0.25;
  answered.estimate.report.ms_consensus = answered.estimate.report.ms_total = 3.5;
  return answered;
}

TEST_CASE("the text of an essential matrix has model, pose, inliers, noise and times") {
  const Answered answered = AnsweredPair(TaskFromString("essential"), 60);
  const std::string text = PairText(answered.pair, answered.estimate, {100.0, 20.0});
  CHECK_THAT(text, Contains("a-b: 60 matches") && Contains("48 inliers (80 %), noise 0.25 px") && Contains("  E = ") &&
                       Contains("  R = ") && Contains("turned by") && Contains("x2 = R x1 + t") &&
                       Contains("keypoints 100, matching 20, consensus 3.5"));
}

TEST_CASE("the text of a fundamental matrix without calibration has no pose, that of a failure says why") {
  Answered answered = AnsweredPair(TaskFromString("fundamental"), 60);
  CHECK_THAT(PairText(answered.pair, answered.estimate, {}), Contains("  F = ") && !Contains("R ="));
  answered.estimate = Estimate();
  answered.estimate.status = Status::kTooFewPoints;
  CHECK_THAT(PairText(answered.pair, answered.estimate, {}), Contains("no fundamental matrix: too_few_points"));
}

TEST_CASE("matches are written with all digits") {
  const Answered answered = AnsweredPair(TaskFromString("essential"), 60);
  const Problem& problem = answered.pair.problem;
  const std::string text = MatchesText(problem);
  CHECK(std::count(text.begin(), text.end(), '\n') == 60);
  std::istringstream lines(text);
  for (int i = 0; i < 60; ++i) {
    double value = 0.0;
    for (int c = 0; c < 4; ++c) CHECK((lines >> value && value == problem.points(i, c)));
    CHECK((lines >> value && value == (problem.match_ratio.size() > 0 ? problem.match_ratio[i] : 1.0)));
  }
}

TEST_CASE("the JSON says the same") {
  const Answered answered = AnsweredPair(TaskFromString("essential"), 60);
  const auto json = nlohmann::json::parse(PairJson(answered.pair, answered.estimate, {100.0, 20.0}));
  CHECK(json.at("status") == "ok");
  CHECK(json.at("inliers").size() == 48);
  CHECK(json.at("inliers")[0] == 12);
  CHECK(json.at("model").size() == 9);
  CHECK(json.at("pose").at("R").size() == 3);
  CHECK(json.at("noise_scale_px") == 0.25);
  CHECK_FALSE(json.at("may_be_chance").get<bool>());
  const auto none = nlohmann::json::parse(PairJson(answered.pair, Estimate(), {}));
  CHECK(none.at("pose").is_null());
  CHECK(none.at("status") == "no_model");
}

}  // namespace
}  // namespace diffsac
