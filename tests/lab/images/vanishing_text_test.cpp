#include "lab/images/vanishing_text.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

namespace diffsac {
namespace {

using Catch::Contains;

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
