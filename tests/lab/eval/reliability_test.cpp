#include "lab/eval/reliability.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

using Catch::Contains;

TEST_CASE("points are counted by what is said of them") {
  Reliability reliability;
  CHECK(reliability.empty());
  CHECK(std::isnan(reliability.CalibrationError()));
  reliability.Add(std::vector<float>{0.05f, 0.15f, 0.16f, 1.0f, 0.0f}, std::vector<std::uint8_t>{0, 1, 0, 1, 1});
  CHECK(reliability.bins()[0].points == 2);
  CHECK(reliability.bins()[0].inliers == 1);
  CHECK(reliability.bins()[1].predicted == Approx(0.31));
  CHECK(reliability.bins()[9].inliers == 1);
  // |1 − .05| + |1 − .31| + |1 − 1| over five points.
  CHECK(reliability.CalibrationError() == Approx((0.95 + 0.69) / 5));
  const Reliability before = reliability;
  reliability.Add(std::vector<float>{0.5f}, std::vector<std::uint8_t>{});  // No truth.
  reliability.Add(std::vector<float>{}, std::vector<std::uint8_t>{1});     // No probabilities.
  CHECK(reliability == before);
  reliability.Add(before);
  CHECK(reliability.bins()[1].points == 4);
}

TEST_CASE("calibrated probabilities lie on the diagonal, others do not") {
  Rng rng(5);
  Reliability right, bold;
  for (int problem = 0; problem < 20; ++problem) {
    std::vector<float> p, twice;
    std::vector<std::uint8_t> inliers;
    for (int i = 0; i < 500; ++i) {
      p.push_back(static_cast<float>(0.5 * rng.Uniform()));
      twice.push_back(2.0f * p.back());
      inliers.push_back(rng.Uniform() < p.back());
    }
    right.Add(p, inliers);
    bold.Add(twice, inliers);
  }
  CHECK(right.CalibrationError() < 0.02);
  CHECK(bold.CalibrationError() == Approx(0.25).margin(0.03));
}

TEST_CASE("scenes count alike, whatever their size, and the file has every bin that has points") {
  ReliabilityCurve curve{"a \"row\"", 0, {}};
  curve.scenes["large"].Add(std::vector<float>(100, 0.95f), std::vector<std::uint8_t>(100, 1));
  curve.scenes["small"].Add(std::vector<float>{0.95f}, std::vector<std::uint8_t>{0});
  CHECK(curve.Share(9) == Approx(0.5));
  CHECK(std::isnan(curve.Share(3)));
  CHECK(curve.CalibrationError() == Approx(0.5));
  const std::string csv = ReliabilityCsv({curve}, {"all"});
  CHECK_THAT(csv, Contains("\"a \"\"row\"\"\",all,mean,0.9,1.0,101,0.9500,0.5000\n"));
  CHECK_THAT(csv, Contains(",large,0.9,1.0,100,0.9500,1.0000\n") && !Contains(",0.3,0.4,"));
  CHECK_THAT(csv, Contains("calibration_error,,,,0.5000,"));
}

TEST_CASE("rows that say the same are shown once, the ratio last, and shards add up") {
  const auto curve = [](const std::string& label, std::size_t condition, float p) {
    ReliabilityCurve made{label, condition, {}};
    made.scenes["s"].Add(std::vector<float>{p}, std::vector<std::uint8_t>{1});
    return made;
  };
  const std::vector<ReliabilityCurve> all = {curve("a", 0, 0.5f), curve(kRatioLabel, 0, 0.2f),
                                             curve("b", 0, 0.5f), curve(kRatioLabel, 0, 0.3f),
                                             curve("c", 0, 0.7f), curve("a", 1, 0.5f)};
  std::string shown;
  for (const ReliabilityCurve& one : DistinctCurves(all)) shown += one.label + std::to_string(one.condition) + " ";
  CHECK(shown == "a0 c0 by the matching ratio0 a1 ");
  std::vector<ReliabilityCurve> joined;
  AddCurves({curve("a", 0, 0.5f), curve("a", 1, 0.5f)}, &joined);
  AddCurves({curve("b", 0, 0.5f), curve("a", 0, 0.55f)}, &joined);
  REQUIRE(joined.size() == 3);
  CHECK(joined[0].scenes.at("s").bins()[5].points == 2);
}

}  // namespace
}  // namespace diffsac
