#include "diffsac/geometry/vanishing_point.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <limits>

#include "geometry/segments.h"

namespace diffsac {
namespace {

using testing::SegmentsTowards;

double AngleDegrees(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180.0 / 3.14159265358979;
}

const Eigen::Vector3d kPoints[] = {Eigen::Vector3d(0.3, -0.2, 1.0).normalized(), Eigen::Vector3d(1.0, 0.0, 0.0),
                                   Eigen::Vector3d(0.05, 1.0, -0.01).normalized(),
                                   Eigen::Vector3d(5.0, 1.0, 1.0).normalized()};

}  // namespace

TEST_CASE("two segments meet in their vanishing point, at infinity too") {
  for (const Eigen::Vector3d& truth : kPoints) {
    const PointMatrix segments = SegmentsTowards(truth, 2, 0.0, Rng(3));
    const int set[] = {0, 1};
    Eigen::Vector3d model;
    REQUIRE(VanishingPoint::SolveMinimal(segments, set, &model) == 1);
    CHECK(model.norm() == Approx(1.0));
    CHECK(AngleDegrees(model, truth) < 1e-6);
    for (int i = 0; i < 2; ++i) CHECK(VanishingPoint::Residual(model, segments.data() + 4 * i) < 1e-9);
  }
}

TEST_CASE("the residual is the sine of the angle at the segment's middle") {
  const double segment[] = {0.0, 0.0, 2.0, 0.0};
  // Seen from (1, 0): up by 30 degrees; straight up; along the segment; at infinity, by 45 degrees.
  CHECK(VanishingPoint::Residual({1.0 + std::sqrt(3.0), 1.0, 1.0}, segment) == Approx(0.5));
  CHECK(VanishingPoint::Residual({1.0, 7.0, 1.0}, segment) == Approx(1.0));
  CHECK(VanishingPoint::Residual({9.0, 0.0, 1.0}, segment) == Approx(0.0).margin(1e-12));
  CHECK(VanishingPoint::Residual({1.0, -1.0, 0.0}, segment) == Approx(std::sqrt(0.5)));
  const Eigen::Vector3d v(0.3, 0.5, 0.9);
  CHECK(VanishingPoint::Residual(v, segment) == Approx(VanishingPoint::Residual(-2.0 * v, segment)));
}

TEST_CASE("a segment of length 0, and one about the vanishing point, fit nothing") {
  const double point[] = {0.4, 0.4, 0.4, 0.4}, about[] = {-1.0, 0.0, 1.0, 0.0};
  CHECK(VanishingPoint::Residual({0.0, 1.0, 0.0}, point) == 1.0);
  CHECK(VanishingPoint::Residual({0.0, 0.0, 1.0}, about) == 1.0);
}

TEST_CASE("residuals over columns are those of each segment") {
  const PointMatrix segments = testing::RandomSegments(37, Rng(1));
  const Eigen::MatrixXd columns = segments;
  const double* pointers[] = {columns.col(0).data(), columns.col(1).data(), columns.col(2).data(),
                              columns.col(3).data()};
  std::vector<double> residuals(30);
  VanishingPoint::Residuals(kPoints[0], pointers, 5, 35, residuals.data());
  for (int i = 0; i < 30; ++i)
    CHECK(residuals[i] == VanishingPoint::Residual(kPoints[0], segments.data() + 4 * (i + 5)));
}

TEST_CASE("no vanishing point of segments on one line, of no length or not finite") {
  PointMatrix segments(4, 4);
  segments << 0, 0, 1, 1, 2, 2, 3, 3, 0.5, 0.1, 0.5, 0.1, 0, std::numeric_limits<double>::quiet_NaN(), 1, 0;
  Eigen::Vector3d model(0, 0, 1);
  for (const int other : {1, 2, 3}) {
    const int set[] = {0, other};
    CHECK(VanishingPoint::SolveMinimal(segments, set, &model) == 0);
  }
  CHECK_FALSE(VanishingPoint::Determined(segments.topRows(2)));
  CHECK_FALSE(VanishingPoint::Determined(segments.topRows(3)));
  CHECK_FALSE(VanishingPoint::Determined(segments));
  CHECK_FALSE(VanishingPoint::Determined(segments.topRows(1)));
  CHECK_FALSE(VanishingPoint::Fit(segments.topRows(2), Eigen::Vector2d(1, 1), &model));
  PointMatrix parallel(2, 4);
  parallel << 0, 0, 1, 0, 0, 1, 1, 1;
  CHECK(VanishingPoint::Determined(parallel));
}

TEST_CASE("the fit is the least weighted sum of squared residuals") {
  Rng rng(8);
  for (const Eigen::Vector3d& truth : kPoints) {
    const PointMatrix segments = SegmentsTowards(truth, 60, 0.01, rng.Fork("segments"));
    Eigen::VectorXd weights(60);
    for (double& weight : weights) weight = rng.Uniform(0.1, 1.0);
    const auto cost = [&](const Eigen::Vector3d& v) {
      double sum = 0.0;
      for (int i = 0; i < 60; ++i)
        sum += weights[i] * std::pow(VanishingPoint::Residual(v, segments.data() + 4 * i), 2);
      return sum;
    };
    Eigen::Vector3d model;
    REQUIRE(VanishingPoint::Fit(segments, weights, &model));
    CHECK(AngleDegrees(model, truth) < 2.0);
    const double least = cost(model);
    for (int round = 0; round < 50; ++round) {
      Eigen::Vector3d moved = model + 1e-3 * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
      CHECK(cost(moved.normalized()) >= least * (1.0 - 1e-9));
    }
  }
}

TEST_CASE("a segment of weight 0 has no part in the fit") {
  const PointMatrix segments = SegmentsTowards(kPoints[0], 20, 0.01, Rng(2));
  PointMatrix more = testing::Stacked(segments, testing::RandomSegments(5, Rng(4)));
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(25);
  weights.tail(5).setZero();
  Eigen::Vector3d alone, among;
  REQUIRE(VanishingPoint::Fit(segments, Eigen::VectorXd::Ones(20), &alone));
  REQUIRE(VanishingPoint::Fit(more, weights, &among));
  CHECK(AngleDegrees(alone, among) < 1e-9);
}

TEST_CASE("the refinement finds the vanishing point among outliers, from some degrees off") {
  for (const Eigen::Vector3d& truth : kPoints) {
    const PointMatrix segments =
        testing::Stacked(SegmentsTowards(truth, 60, 0.002, Rng(5)), testing::RandomSegments(60, Rng(6)));
    Eigen::Vector3d model = (truth + 0.02 * Eigen::Vector3d(1.0, -1.0, 0.5)).normalized();
    REQUIRE(VanishingPoint::Refine(segments, Eigen::VectorXd::Ones(120), {LossKind::kTruncated, 0.05}, &model));
    CHECK(model.norm() == Approx(1.0));
    CHECK(AngleDegrees(model, truth) < 0.5);
  }
}

TEST_CASE("a refinement that can do nothing leaves the model") {
  const PointMatrix segments = SegmentsTowards(kPoints[0], 20, 0.0, Rng(2));
  Eigen::Vector3d model = kPoints[0];
  const Eigen::Vector3d before = model;
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(20);
  for (const double threshold : {0.0, std::numeric_limits<double>::quiet_NaN()})
    CHECK_FALSE(VanishingPoint::Refine(segments, ones, {LossKind::kTruncated, threshold}, &model));
  CHECK_FALSE(VanishingPoint::Refine(segments, ones.head(3), RobustLoss{}, &model));
  model[0] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(VanishingPoint::Refine(segments, ones, RobustLoss{}, &model));
  model = before;
  CHECK_FALSE(VanishingPoint::Refine(PointMatrix(0, 4), Eigen::VectorXd(0), RobustLoss{}, &model));
  CHECK(model == before);
}

}  // namespace diffsac
