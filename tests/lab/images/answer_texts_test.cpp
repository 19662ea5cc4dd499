#include "lab/images/pair_text.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "diffsac/core/random.h"
#include "diffsac/problem/tasks.h"
#include "geometry/two_view_problems.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/images/vanishing_text.h"

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
  answered.estimate.sigma = 0.25;
  answered.estimate.stats.ms_consensus = answered.estimate.stats.ms_total = 3.5;
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

TEST_CASE("the text and the JSON have the pose's standard deviations and the focal length") {
  Answered answered = AnsweredPair(TaskFromString("essential"), 60);
  Estimate& estimate = answered.estimate;
  const double radian = std::numbers::pi / 180.0;
  Eigen::VectorXd deviations(6);
  deviations << 0.1, 0.3, 0.2, 0.0, 0.5, 0.4;
  estimate.pose_covariance = Eigen::MatrixXd((radian * deviations).cwiseAbs2().asDiagonal());
  estimate.focal = FocalEstimate{{700, 700}, {650, 650}, {760, 760}, {true, true}, {800, 800}, {0.1, 0.1}};
  CHECK_THAT(PairText(answered.pair, estimate, {}),
             Contains("standard deviations by noise alone: R 0.3 degrees, t 0.5 degrees") &&
                 Contains("  f = 700.0 px, 68 % within 650.0 and 760.0\n"));
  auto json = nlohmann::json::parse(PairJson(answered.pair, estimate, {}));
  CHECK(json.at("pose_covariance").size() == 6);
  CHECK(json.at("pose_covariance")[4][4].get<double>() == Approx(std::pow(0.5 * radian, 2)));
  CHECK(json.at("focal").at("px")[1] == 700);
  CHECK(json.at("focal").at("observable")[0].get<bool>());
  CHECK(json.at("focal").at("prior_log_sigma")[1] == 0.1);

  estimate.pose_covariance.reset();
  estimate.focal = FocalEstimate{{700, 900}, {700, 650}, {700, 960}, {true, false}, {700, 800}, {0.0, 0.4}};
  CHECK_THAT(PairText(answered.pair, estimate, {}),
             !Contains("standard deviations") &&
                 Contains("  f1 = 700.0 px, 68 % within 700.0 and 700.0\n  f2 = 900.0 px, 68 % within 650.0 and 960.0: "
                          "not observable, the prior's\n"));
  json = nlohmann::json::parse(PairJson(answered.pair, estimate, {}));
  CHECK(json.at("pose_covariance").is_null());
  CHECK(json.at("focal").at("observable") == nlohmann::json{true, false});
}

// A translation was printed to six digits of an image with itself.
TEST_CASE("the text and the JSON have no digits of a translation that is not determined, and say why") {
  Answered answered = AnsweredPair(TaskFromString("essential"), 60);
  Estimate& estimate = answered.estimate;
  estimate.pure_rotation = Eigen::Matrix3d::Identity();
  for (const auto& [translation, why] :
       {std::pair{Degeneracy::kPureRotation, "t is not determined: the camera only turned"},
        {Degeneracy::kStatic, "t is not determined: the images show no motion"}}) {
    estimate.degeneracy = translation;
    const std::string text = PairText(answered.pair, estimate, {});
    CHECK_THAT(text, Contains(why) && !Contains("t =") && !Contains("E ="));
    CHECK((text.find("R = ") != std::string::npos) == (translation == Degeneracy::kPureRotation));
    const auto json = nlohmann::json::parse(PairJson(answered.pair, estimate, {}));
    CHECK(json.at("degeneracy") == ToString(translation));
    CHECK(json.at("pose").at("t").is_null());
    CHECK(json.at("pose").at("R").size() == 3);
  }
  Answered plane = AnsweredPair(TaskFromString("fundamental"), 60);
  plane.estimate.degeneracy = Degeneracy::kPlane;
  CHECK_THAT(
      PairText(plane.pair, plane.estimate, {}),
      Contains("F is not determined: the matches lie on one plane, or the camera only turned") && !Contains("F ="));
  CHECK(UndeterminedText(Degeneracy::kLine, TaskFromString("homography")) ==
        "H is not determined: the matches lie on one line");
  CHECK(UndeterminedText(Degeneracy::kDetermined, TaskFromString("essential")).empty());
}

TEST_CASE("the other motion of a plane is told, a turn's homography has its rotation, one without cameras no pose") {
  Answered answered = AnsweredPair(Task::kEssential, 60);
  answered.estimate.ambiguous_pose = RigidMotion{Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitY()};
  CHECK_THAT(PairText(answered.pair, answered.estimate, {}),
             Contains("this motion explains the matches as well (a plane, or a zoom):\n  R = ") &&
                 Contains("t =  (0.000000, 1.000000, 0.000000)"));
  const auto json = nlohmann::json::parse(PairJson(answered.pair, answered.estimate, {}));
  CHECK(json.at("ambiguous_pose").at("t")[1] == 1.0);
  Answered plane = AnsweredPair(Task::kHomography, 60);
  CHECK_THAT(PairText(plane.pair, plane.estimate, {}), Contains("H = ") && Contains("no pose: that of a homography"));
  CHECK(nlohmann::json::parse(PairJson(plane.pair, plane.estimate, {})).at("ambiguous_pose").is_null());
  plane.pair.problem.cameras = CameraPair{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  plane.estimate.degeneracy = Degeneracy::kPureRotation;
  plane.estimate.pure_rotation = Eigen::Matrix3d::Identity();
  CHECK_THAT(PairText(plane.pair, plane.estimate, {}),
             Contains("H = ") && Contains("R = ") && Contains("t is not determined: the camera only turned"));
}

TEST_CASE("R and t by a focal length that is a guess are told to be no better") {
  Answered answered = AnsweredPair(Task::kEssential, 60);
  answered.pair.problem.task = Task::kTwoFocals;
  answered.pair.problem.cameras.reset();
  Estimate& estimate = answered.estimate;
  estimate.model.conservativeResize(11);
  estimate.model.tail<2>().setOnes();
  for (const bool observable : {true, false}) {
    estimate.focal = FocalEstimate{{700, 900}, {650, 650}, {760, 960}, {true, observable}, {700, 800}, {0.4, 0.4}};
    const std::string text = PairText(answered.pair, estimate, {});
    CHECK((text.find("R and t are no better than the focal length, which is a guess") == std::string::npos) ==
          observable);
  }
}

TEST_CASE("the text of an absolute pose says where the camera is") {
  Answered answered = AnsweredPair(Task::kEssential, 60);
  Problem& problem = answered.pair.problem;
  problem.task = Task::kAbsolutePose;
  problem.points = PointMatrix::Ones(60, 5);
  answered.estimate.model.resize(12);
  answered.estimate.model << 1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3;
  CHECK_THAT(PairText(answered.pair, answered.estimate, {}),
             Contains("a-b: 60 points") && Contains("absolute pose: 48 inliers") &&
                 Contains("t =  (1, 2, 3), in the scene's unit") && Contains("the camera is at (-1, -2, -3)") &&
                 !Contains("E ="));
}

TEST_CASE("the JSON has the images, the method, the seed, K and the matches, no text has a number of 300 digits") {
  Answered answered = AnsweredPair(TaskFromString("essential"), 60);
  const Problem& problem = answered.pair.problem;
  const PairRun run{"photos/a.jpg", "photos/b.jpg", "learned_prosac", 7};
  const auto json = nlohmann::json::parse(PairJson(answered.pair, answered.estimate, {}, run));
  CHECK(json.at("image1") == "photos/a.jpg");
  CHECK(json.at("image2") == "photos/b.jpg");
  CHECK(json.at("method") == "learned_prosac");
  CHECK(json.at("seed") == 7);
  CHECK(json.at("K1")[0][2].get<double>() == problem.cameras->K1(0, 2));
  CHECK(json.at("matches") == 60);
  REQUIRE(json.at("correspondences").size() == 60);
  for (int c = 0; c < 4; ++c)
    CHECK(json.at("correspondences")[3][c].get<double>() == Approx(problem.points(3, c)).margin(1e-4));
  CHECK(json.at("principal_point2") == nlohmann::json({problem.cameras->K2(0, 2), problem.cameras->K2(1, 2)}));
  CHECK(json.at("size1") == nlohmann::json({1000, 800}));
  Answered focals = AnsweredPair(TaskFromString("two_focals"), 60);
  focals.pair.problem.cameras.reset();
  focals.pair.problem.size1 = {};
  focals.pair.problem.size2 = {640, 480};
  const auto sized = nlohmann::json::parse(PairJson(focals.pair, Estimate(), {}, run));
  CHECK(sized.at("size2") == nlohmann::json({640, 480}));
  CHECK(sized.at("principal_point2") == nlohmann::json({319.5, 239.5}));
  CHECK(sized.at("principal_point1").is_null());
  const Answered plain = AnsweredPair(TaskFromString("fundamental"), 60);
  CHECK(nlohmann::json::parse(PairJson(plain.pair, plain.estimate, {}, run)).at("K2").is_null());
  answered.estimate.focal = FocalEstimate{{1e300, 1e300}, {650, 650}, {1e300, 1e300}, {}, {800, 800}, {0.1, 0.1}};
  CHECK_THAT(PairText(answered.pair, answered.estimate, {}), Contains("f = 1e+300 px, 68 % within 650.0 and 1e+300"));
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
    CHECK((lines >> value && value == (problem.snn_ratio.size() > 0 ? problem.snn_ratio[i] : 1.0)));
  }
  Problem framed = problem;
  framed.scale_rotation_changes = PointMatrix::Constant(60, 2, 0.25);
  CHECK(MatchesText(framed).starts_with(text.substr(0, text.find('\n')) + " 0.25 0.25\n"));
}

TEST_CASE("the JSON says the same") {
  const Answered answered = AnsweredPair(TaskFromString("essential"), 60);
  const auto json = nlohmann::json::parse(PairJson(answered.pair, answered.estimate, {100.0, 20.0}));
  CHECK(json.at("status") == "ok");
  CHECK(json.at("inliers").size() == 48);
  CHECK(json.at("inliers")[0] == 12);
  CHECK(json.at("model").size() == 9);
  CHECK(json.at("pose").at("R").size() == 3);
  CHECK(json.at("sigma_px") == 0.25);
  CHECK_FALSE(json.at("may_be_chance").get<bool>());
  CHECK(json.at("num_duplicates") == 0);
  Estimate repeated = answered.estimate;
  repeated.num_duplicates = 3;
  repeated.num_nonfinite = 2;
  CHECK(nlohmann::json::parse(PairJson(answered.pair, repeated, {})).at("num_nonfinite") == 2);
  CHECK_THAT(PairText(answered.pair, repeated, {}), Contains(": 60 matches, 3 repeated, 2 not finite\n"));
  Estimate ignored = answered.estimate;
  ignored.scores_ignored = true;
  CHECK(nlohmann::json::parse(PairJson(answered.pair, ignored, {})).at("scores_ignored") == true);
  CHECK_THAT(PairText(answered.pair, ignored, {}), Contains(": 60 matches, their ratios or scores not used\n"));
  const auto none = nlohmann::json::parse(PairJson(answered.pair, Estimate(), {}));
  CHECK(none.at("pose").is_null());
  CHECK(none.at("status") == "no_model");
}

constexpr ImageSize kSize = {640, 480};

VanishingImage Found() {
  VanishingImage found;
  found.image.name = "hall";
  found.image.size = kSize;
  found.image.segments.resize(3, 4);
  found.image.segments << 1, 2, 3, 4, 5, 6, 7, 8.25, 9, 10, 11, 12;
  VanishingPointsEstimate& estimate = found.estimate;
  estimate.status = Status::kOk;
  estimate.points = {Eigen::Vector3d(300.0, 200.0, 1.0).normalized(), Eigen::Vector3d(0.0, 1.0, 0.0)};
  estimate.values = {0.91, 0.5};
  estimate.assignment = {1, 0, 1};
  Horizon& horizon = estimate.horizon.emplace();
  horizon.line = Eigen::Vector3d(0.1, 1.0, -232.05) / std::sqrt(1.01);
  horizon.up = {0.0, -1.0, 0.0};
  horizon.vertical = 1;
  horizon.horizontal = {0};
  return found;
}

void AddCamera(VanishingImage* found) {
  found->estimate.K = Eigen::Matrix3d{{500, 0, 319.5}, {0, 500, 239.5}, {0, 0, 1}};
  for (const Eigen::Vector3d& point : found->estimate.points)
    found->estimate.directions.push_back(DirectionOf(point, *found->estimate.K));
}

}  // namespace

TEST_CASE("a vanishing point is where it is, or at infinity along a direction to the right or down") {
  CHECK(PlaceText({600.0, -400.0, 2.0}, kSize) == "(300.0, -200.0)");
  CHECK(PlaceText({0.0, -1.0, 0.0}, kSize) == "at infinity along (0.00, 1.00)");
  CHECK(PlaceText({-0.8, 0.6, 0.0}, kSize) == "at infinity along (0.80, -0.60)");
  CHECK(PlaceText({-0.004, -1.0, 0.0}, kSize) == "at infinity along (0.00, 1.00)");
  CHECK(PlaceText({-1.0, 0.004, 0.0}, kSize) == "at infinity along (1.00, 0.00)");
  CHECK(PlaceText({319.5, 1e6, 1.0}, kSize) == "at infinity along (0.00, 1.00)");
}

TEST_CASE("the text says points, segments, focal length and horizon, as far as they are known") {
  VanishingImage found = Found();
  CHECK_THAT(VanishingText(found),
             Contains("hall: 640 x 480 pixels, 3 segments\n") && Contains("2 vanishing points, the surest first\n") &&
                 Contains("(300.0, 200.0)") && Contains("2 segments  sure 0.91") &&
                 Contains("at infinity along (0.00, 1.00)") && !Contains("direction (") &&
                 Contains("focal length: not determined") &&
                 Contains("horizon: row 200.1 in the middle, rises to the right by 5.71 degrees\n"));
  found.estimate.horizon->line = {0.0, 1.0, -100.0};
  CHECK_THAT(VanishingText(found), Contains("horizon: row 100.0 in the middle, level\n"));
  AddCamera(&found);
  CHECK_THAT(VanishingText(found), Contains("direction (") && Contains("focal length: 500 px, as given\n") &&
                                       Contains("the camera looks up by 0.0 degrees"));
  found.exif = true;
  CHECK_THAT(VanishingText(found), Contains("500 px, by EXIF data\n"));
  found.estimate.focal = VanishingFocal{500.0, 0.05, {0, 1}};
  CHECK_THAT(VanishingText(found), Contains("500 px (standard deviation 5 %), since 1 and 2 are orthogonal\n"));
  found.estimate.values.clear();
  CHECK_THAT(VanishingText(found), Contains("2 vanishing points, that of most length first") && !Contains("sure"));
  found.estimate = {};
  found.estimate.status = Status::kTooFewPoints;
  CHECK_THAT(VanishingText(found), Contains("no vanishing points: too_few_points\n") && !Contains("horizon"));
}

TEST_CASE("segments have all digits and the number of their vanishing point") {
  CHECK(SegmentsText(Found()) == "1 2 3 4 1\n5 6 7 8.25 0\n9 10 11 12 1\n");
}

TEST_CASE("the JSON has everything, null where it is not known") {
  VanishingImage known = Found(), failed = Found();
  AddCamera(&known);
  failed.estimate = {};
  const auto json = nlohmann::json::parse(VanishingJson({known, Found(), failed}));
  REQUIRE(json["images"].size() == 3);
  const auto& first = json["images"][0];
  CHECK(first["image"] == "hall");
  CHECK(first["K"][0][0] == 500.0);
  CHECK(first["K_from"] == "given");
  CHECK(first["vanishing_points"][0]["segments"] == 2);
  CHECK(first["vanishing_points"][1]["direction"][1] == -1.0);
  CHECK(first["assignment"] == std::vector<int>{1, 0, 1});
  CHECK(first["horizon"]["vertical"] == 2);
  CHECK(first["horizon"]["horizontal"] == std::vector<int>{1});
  const auto& second = json["images"][1];
  CHECK(second["K"].is_null());
  CHECK(second["K_from"] == "none");
  CHECK(second["horizon"]["pitch_deg"].is_null());
  CHECK(second["vanishing_points"][0]["direction"].is_null());
  CHECK(json["images"][2]["status"] == "no_model");
  CHECK(json["images"][2]["vanishing_points"].empty());
}

}  // namespace diffsac
