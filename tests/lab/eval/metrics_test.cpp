#include "lab/eval/metrics.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

namespace diffsac {
namespace {

TEST_CASE("errors at a threshold count as accurate") {
  CHECK(AverageAccuracy(0.0, 0.5) == 1.0);
  CHECK(AverageAccuracy(0.5, 0.5) == Approx(0.1));
  CHECK(AverageAccuracy(std::nextafter(0.5, 1.0), 0.5) == 0.0);
  CHECK(AverageAccuracy(0.25, 0.5) == Approx(0.6));
  CHECK(AverageAccuracy(10.0, 10.0) == Approx(0.1));
  CHECK(AverageAccuracy(std::nan(""), 1.0) == 0.0);
  CHECK(std::isnan(Median({})));
  CHECK(std::isnan(Mean({})));
}

TEST_CASE("the median ignores NaN and keeps infinities") {
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(Median({3.0, std::nan(""), 1.0}) == 2.0);
  CHECK(Median({1.0, inf, inf}) == inf);
  CHECK(Median({2.0, 1.0, 4.0, 3.0}) == 2.5);
}

Example LineExample() {
  Example example;
  example.problem.points.resize(4, 2);
  example.problem.points << 0, 0, 2, 0, 2, 2, 0, 2;
  example.truth.model = Eigen::Vector3d(0.0, 1.0, -1.0);  // y = 1, through the centroid (1, 1)
  return example;
}

TEST_CASE("a parallel line has an offset and no angle, whatever its sign") {
  const Example example = LineExample();
  Estimate estimate;
  estimate.status = Status::kOk;
  for (const double sign : {1.0, -1.0}) {
    estimate.model = sign * Eigen::Vector3d(0.0, 1.0, -1.25);
    const EstimateError error = MeasureError(estimate, example);
    CHECK_FALSE(error.failed);
    CHECK(error.angle_deg == Approx(0.0).margin(1e-9));
    CHECK(error.offset == Approx(0.25));
  }
}

TEST_CASE("a failure is the worst error") {
  const Example example = LineExample();
  Estimate estimate;
  for (int kind = 0; kind < 3; ++kind) {
    estimate.status = kind == 0 ? Status::kNoModel : Status::kOk;
    if (kind == 2) estimate.model = Eigen::Vector3d(std::nan(""), 1.0, 0.0);
    const EstimateError error = MeasureError(estimate, example);
    CHECK(error.failed);
    CHECK(error.angle_deg == 90.0);
    CHECK(error.offset == Approx(std::sqrt(8.0)));
  }
}

TEST_CASE("without ground truth the errors are unknown, and a failure is still a failure") {
  Example example = LineExample();
  example.truth.model.resize(0);
  const EstimateError error = MeasureError(Estimate(), example);
  CHECK(std::isnan(error.angle_deg));
  CHECK(std::isnan(error.offset));
  CHECK(error.failed);
}

}  // namespace
}  // namespace diffsac
