#include "lab/eval/metrics.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

// The worked example of the field notes, section 4.2.
const std::vector<double> kErrors = {0.5, 1.0, 3.2, 9.9, 10.0, 12.0, 180.0};

TEST_CASE("metrics of the worked example") {
  CHECK(MeanAverageAccuracy(kErrors, 10.0) == Approx(0.414286).margin(5e-7));
  CHECK(AreaUnderCurve(kErrors, 5.0) == Approx(0.340000).margin(5e-7));
  CHECK(AreaUnderCurve(kErrors, 10.0) == Approx(0.433571).margin(5e-7));
  CHECK(AreaUnderCurve(kErrors, 20.0) == Approx(0.638571).margin(5e-7));
  CHECK(AccuracyWithin(kErrors, 10.0) == Approx(5.0 / 7.0));
  CHECK(Median(kErrors) == 9.9);
}

TEST_CASE("the area under the recall as CONSAC's program computes it") {
  struct Golden {
    std::vector<double> errors;
    double at_5, at_10;
  };
  // calc_auc of fkluger/consac, util/auc.py, for each; it fails where no error is below the threshold.
  const Golden all[] = {{{12, 0.3, 90, 4, 0.8, 2.5, 7, 1.2}, 0.459205, 0.606217},
                        {{0.5, 2, 5, 5, 7, 10, 40}, 0.278571, 0.503571},
                        {{1, 3, 5}, 0.533333, 0.766667},
                        {{1, 3, 5, 8}, 0.400000, 0.662500},
                        {{0.5, 1, 2, 3}, 0.737500, 0.868750},
                        {{1, 90, 90, 90}, 0.298901, 0.336264},
                        {{3, 30}, 0.290909, 0.509091},
                        {{0, 0, 6, 20}, 0.625000, 0.713462},
                        {{6, 8, 20}, 0.0, 0.257143}};
  for (const Golden& golden : all) {
    CHECK(RecallArea(golden.errors, 5.0) == Approx(golden.at_5).margin(6e-7));
    CHECK(RecallArea(golden.errors, 10.0) == Approx(golden.at_10).margin(6e-7));
  }
  CHECK(std::isnan(RecallArea({}, 5.0)));
  CHECK(RecallArea(std::vector<double>{12, 20, 90}, 10.0) == 0.0);
}

TEST_CASE("errors at a threshold count as accurate") {
  CHECK(AverageAccuracy(0.0, 0.5) == 1.0);
  CHECK(AverageAccuracy(0.5, 0.5) == Approx(0.1));
  CHECK(AverageAccuracy(std::nextafter(0.5, 1.0), 0.5) == 0.0);
  CHECK(AverageAccuracy(0.25, 0.5) == Approx(0.6));
  CHECK(AverageAccuracy(10.0, 10.0) == Approx(0.1));
  CHECK(AccuracyWithin(std::vector<double>{0.5}, 0.5) == 1.0);
}

TEST_CASE("non-finite errors are accurate nowhere and still count") {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const std::vector<double> errors = {0.0, nan, inf, 90.0};
  CHECK(MeanAverageAccuracy(errors, 1.0) == 0.25);
  CHECK(AreaUnderCurve(errors, 1.0) == 0.25);
  CHECK(AccuracyWithin(errors, 1.0) == 0.25);
}

TEST_CASE("no errors give NaN") {
  CHECK(std::isnan(MeanAverageAccuracy({}, 1.0)));
  CHECK(std::isnan(AreaUnderCurve({}, 1.0)));
  CHECK(std::isnan(AccuracyWithin({}, 1.0)));
  CHECK(std::isnan(Median({})));
  CHECK(std::isnan(Mean({})));
}

TEST_CASE("metrics lie within [0, 1], are ordered, and never fall when an error falls") {
  Rng rng(5);
  for (int round = 0; round < 50; ++round) {
    std::vector<double> errors;
    for (int i = 0; i < 20; ++i) errors.push_back(rng.Uniform(0.0, 1.5));
    const double accuracy = MeanAverageAccuracy(errors, 1.0);
    CHECK(accuracy >= 0.0);
    CHECK(accuracy <= AccuracyWithin(errors, 1.0));
    const double area = AreaUnderCurve(errors, 1.0);
    std::vector<double> better = errors;
    better[rng.Below(20)] *= 0.5;
    CHECK(MeanAverageAccuracy(better, 1.0) >= accuracy);
    CHECK(AreaUnderCurve(better, 1.0) >= area - 1e-12);
  }
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
