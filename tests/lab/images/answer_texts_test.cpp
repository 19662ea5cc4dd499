#include "lab/images/pair_text.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>

#include "diffsac/core/random.h"
#include "geometry/two_view_problems.h"
#include "lab/images/vanishing_text.h"

namespace diffsac {
namespace {

using Catch::Contains;

// Twelve outliers and the others right, with the true model as the estimate.
ImagePair AnsweredPair(Task task, int points = 60) {
  Rng rng(4);
  const testing::TwoViewProblem random = testing::RandomProblem(points, rng, 0.0);
  ImagePair pair;
  pair.example.id = "a-b";
  pair.ms_keypoints = 100.0;
  pair.ms_matching = 20.0;
  Problem& problem = pair.example.problem;
  problem.task = task;
  problem.points = random.pixels;
  problem.size1 = problem.size2 = {1000, 800};
  if (task == Task::kEssential) problem.cameras = CameraPair{random.k1, random.k2};
  PairEstimate& estimate = pair.estimate;
  estimate.status = Status::kOk;
  estimate.verdict = Verdict::kReliable;
  estimate.matrix = AsMatrix(problem.cameras ? random.essential : random.fundamental);
  if (task != Task::kFundamental) estimate.pose = RigidMotion{Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitX()};
  estimate.inliers.assign(static_cast<std::size_t>(points), 1);
  std::fill_n(estimate.inliers.begin(), 12, 0);
  estimate.num_inliers = points - 12;
  estimate.sigma = 0.25;
  estimate.task = task;
  estimate.guidance = Guidance::kNetwork;
  estimate.seed = 7;
  estimate.stats.ms_consensus = estimate.stats.ms_total = 3.5;
  return pair;
}

Json JsonOf(const ImagePair& pair) { return PairJson(pair, "photos/a.jpg", "photos/b.jpg"); }

TEST_CASE("a text has model pose inliers noise and times") {
  CHECK_THAT(PairText(AnsweredPair(Task::kEssential)),
             Contains("a-b: 60 matches") && Contains("48 inliers (80 %), noise 0.25 px") && Contains("  E = ") &&
                 Contains("  R = ") && Contains("turned by") && Contains("x2 = R x1 + t") &&
                 Contains("keypoints 100, matching 20, consensus 3.5"));
}

TEST_CASE("without calibration no pose and failures say why") {
  ImagePair pair = AnsweredPair(Task::kFundamental);
  CHECK_THAT(PairText(pair), Contains("  F = ") && !Contains("R ="));
  pair.estimate = {};
  pair.estimate.status = Status::kTooFewPoints;
  CHECK_THAT(PairText(pair), Contains("no fundamental matrix: too_few_points"));
  CHECK(JsonOf(pair).at("pose").is_null());
  CHECK(JsonOf(pair).at("status") == "too_few_points");
  CHECK(JsonOf(pair).at("model").empty());
}

TEST_CASE("standard deviations and focal lengths are told") {
  ImagePair pair = AnsweredPair(Task::kTwoFocals);
  PairEstimate& estimate = pair.estimate;
  const double radian = std::numbers::pi / 180.0;
  Eigen::VectorXd deviations(6);
  deviations << 0.1, 0.3, 0.2, 0.0, 0.5, 0.4;
  estimate.pose_covariance = Eigen::MatrixXd((radian * deviations).cwiseAbs2().asDiagonal());
  estimate.focal = FocalEstimate{{700, 700}, {650, 650}, {760, 760}, {true, true}, {800, 800}, {0.1, 0.1}};
  CHECK_THAT(PairText(pair), Contains("standard deviations by noise alone: R 0.3 degrees, t 0.5 degrees") &&
                                 Contains("  f = 700.0 px, 68 % within 650.0 and 760.0\n"));
  CHECK(JsonOf(pair).at("pose_covariance")[4][4].get<double>() == Approx(std::pow(0.5 * radian, 2)));
  CHECK(JsonOf(pair).at("focal").at("px")[1] == 700);
  CHECK(JsonOf(pair).at("focal").at("prior_log_sigma")[1] == 0.1);
  estimate.pose_covariance.reset();
  estimate.focal = FocalEstimate{{700, 900}, {700, 650}, {700, 960}, {true, false}, {700, 800}, {0.0, 0.4}};
  estimate.focal_from = {FocalSource::kMatches, FocalSource::kPrior};
  CHECK_THAT(PairText(pair),
             !Contains("standard deviations") && Contains("  f1 = 700.0 px, 68 % within 700.0 and 700.0\n") &&
                 Contains("  f2 = 900.0 px, 68 % within 650.0 and 960.0: not observable, the prior's\n") &&
                 Contains("R and t are no better than the focal length, which is a guess"));
  CHECK(JsonOf(pair).at("pose_covariance").is_null());
  CHECK(JsonOf(pair).at("focal").at("source") == Json({"matches", "prior"}));
  CHECK_FALSE(JsonOf(pair).at("sure").get<bool>());
  estimate.focal_from[1] = FocalSource::kExif;
  CHECK_THAT(PairText(pair), Contains("not observable, EXIF's") && !Contains("which is a guess"));
  estimate.focal = FocalEstimate{{1e300, 1e300}, {650, 650}, {1e300, 1e300}, {}, {800, 800}, {0.1, 0.1}};
  CHECK_THAT(PairText(pair), Contains("f = 1e+300 px, 68 % within 650.0 and 1e+300"));
}

// A translation was printed to six digits of an image with itself.
TEST_CASE("what is not determined has no digits") {
  ImagePair pair = AnsweredPair(Task::kEssential);
  pair.estimate.pose->translation.setZero();
  for (const auto& [degeneracy, why] :
       {std::pair{Degeneracy::kPureRotation, "t is not determined: the camera only turned"},
        {Degeneracy::kStatic, "t is not determined: the images show no motion"}}) {
    pair.estimate.diagnostics.degeneracy = degeneracy;
    const std::string text = PairText(pair);
    CHECK_THAT(text, Contains(why) && !Contains("t =") && !Contains("E ="));
    CHECK((text.find("R = ") != std::string::npos) == (degeneracy == Degeneracy::kPureRotation));
    CHECK(JsonOf(pair).at("degeneracy") == ToString(degeneracy));
    CHECK(JsonOf(pair).at("pose").at("t").is_null());
    CHECK(JsonOf(pair).at("pose").at("R").size() == 3);
  }
  ImagePair plane = AnsweredPair(Task::kFundamental);
  plane.estimate.diagnostics.degeneracy = Degeneracy::kPlane;
  CHECK_THAT(PairText(plane), Contains("F is not determined: the matches lie on one plane") && !Contains("F ="));
}

TEST_CASE("motions of planes and turns are told") {
  ImagePair pair = AnsweredPair(Task::kEssential);
  pair.estimate.ambiguous_pose = RigidMotion{Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitY()};
  CHECK_THAT(PairText(pair), Contains("this motion explains the matches as well (a plane, or a zoom):\n  R = ") &&
                                 Contains("t =  (0.000000, 1.000000, 0.000000)"));
  CHECK(JsonOf(pair).at("ambiguous_pose").at("t")[1] == 1.0);
  ImagePair plane = AnsweredPair(Task::kHomography);
  CHECK_THAT(PairText(plane), Contains("H = ") && Contains("no pose: that of a homography"));
  plane.example.problem.cameras = CameraPair{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()};
  plane.estimate.diagnostics.degeneracy = Degeneracy::kPureRotation;
  plane.estimate.pose->translation.setZero();
  CHECK_THAT(PairText(plane), Contains("H = ") && Contains("R = ") && Contains("the camera only turned"));
}

TEST_CASE("the text of an absolute pose places the camera") {
  ImagePair pair = AnsweredPair(Task::kEssential);
  pair.example.problem.task = Task::kAbsolutePose;
  pair.example.problem.points = PointMatrix::Ones(60, 5);
  pair.estimate.pose->translation = {1, 2, 3};
  CHECK_THAT(PairText(pair), Contains("a-b: 60 points") && Contains("absolute pose: 48 inliers") &&
                                 Contains("t =  (1, 2, 3), in the scene's unit") &&
                                 Contains("the camera is at (-1, -2, -3)") && !Contains("E ="));
  CHECK(JsonOf(pair).at("model").size() == 12);
  CHECK(JsonOf(pair).at("model")[3] == 1.0);
}

TEST_CASE("the JSON of a pair has everything") {
  ImagePair pair = AnsweredPair(Task::kEssential);
  const Problem& problem = pair.example.problem;
  const Json json = JsonOf(pair);
  CHECK(json.at("image1") == "photos/a.jpg");
  CHECK(json.at("method") == "network");
  CHECK(json.at("seed") == 7);
  CHECK(json.at("K1")[0][2].get<double>() == problem.cameras->K1(0, 2));
  CHECK(json.at("matches") == 60);
  CHECK(json.at("inliers").size() == 48);
  CHECK(json.at("inliers")[0] == 12);
  CHECK(json.at("model").size() == 9);
  CHECK(json.at("sigma_px") == 0.25);
  CHECK(json.at("verdict") == "reliable");
  CHECK_FALSE(json.at("may_be_chance").get<bool>());
  CHECK(json.at("principal_point2") == Json({problem.cameras->K2(0, 2), problem.cameras->K2(1, 2)}));
  CHECK(json.at("size1") == Json({1000, 800}));
  CHECK(CorrespondencesJson(problem).size() == 60);
  CHECK(CorrespondencesJson(problem)[3][2].get<double>() == Approx(problem.points(3, 2)).margin(1e-4));
  ImagePair focals = AnsweredPair(Task::kTwoFocals);
  focals.example.problem.size1 = {};
  focals.example.problem.size2 = {640, 480};
  CHECK(JsonOf(focals).at("principal_point2") == Json({319.5, 239.5}));
  CHECK(JsonOf(focals).at("principal_point1").is_null());
  CHECK(JsonOf(focals).at("K2").is_null());
}

TEST_CASE("rows that are not used are counted") {
  ImagePair pair = AnsweredPair(Task::kEssential);
  pair.estimate.diagnostics.num_duplicates = 3;
  pair.estimate.diagnostics.num_nonfinite = 2;
  CHECK_THAT(PairText(pair), Contains(": 60 matches, 3 repeated, 2 not finite\n"));
  CHECK(JsonOf(pair).at("num_nonfinite") == 2);
  pair.estimate.diagnostics = {};
  pair.estimate.diagnostics.scores_ignored = true;
  CHECK_THAT(PairText(pair), Contains(": 60 matches, their ratios or scores not used\n"));
}

TEST_CASE("matches are written with all digits") {
  const Problem problem = AnsweredPair(Task::kEssential).example.problem;
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
