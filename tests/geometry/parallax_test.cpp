#include "diffsac/geometry/parallax.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/essential.h"
#include "geometry/planar_scene.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::MakePlanarScene;
using testing::RandomDirection;
using testing::RandomProblem;
using testing::TwoViewProblem;

constexpr double kFocal = 1000.0;

/// Matches of a camera that turned and did not move, `wrong` of them anywhere; noise in pixels of `kFocal`.
TwoViewProblem Turned(int count, double noise, double wrong, Rng& rng, double degrees = 12.0) {
  TwoViewProblem problem = RandomProblem(count, rng);
  const Eigen::Vector3d axis = RandomDirection(rng);
  problem.pose.rotation = Eigen::AngleAxisd(degrees * 0.017453292519943295, axis).toRotationMatrix();
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d ray(rng.Uniform(-0.7, 0.7), rng.Uniform(-0.5, 0.5), 1.0);
    problem.normalized.row(i) << ray.head<2>().transpose(), (problem.pose.rotation * ray).hnormalized().transpose();
    for (int j = 0; j < 4; ++j) problem.normalized(i, j) += noise / kFocal * rng.Normal();
    if (i < wrong * count) problem.normalized.row(i).tail<2>() << rng.Uniform(-0.7, 0.7), rng.Uniform(-0.5, 0.5);
  }
  return problem;
}

/// E of the rotation and any translation, fitted to the matches within a pixel of it, which `inliers` become.
Matrix3Parameters AnyEssential(const TwoViewProblem& problem, Rng& rng, std::vector<std::uint8_t>* inliers) {
  Matrix3Parameters e = AsParameters(EssentialFromPose({problem.pose.rotation, RandomDirection(rng)}));
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(problem.normalized.rows());
  Essential::Refine(problem.normalized, ones, {LossKind::kTruncated, 1.0 / kFocal}, &e);
  const Eigen::VectorXd residuals = RowResiduals<Essential>(problem.normalized, e);
  inliers->clear();
  for (const double residual : residuals) inliers->push_back(residual <= 1.0 / kFocal);
  return e;
}

}  // namespace

// Told as certain from .35 px of noise on, and with two wrong inliers of 200.
TEST_CASE("a pure rotation is told at every noise, with wrong inliers, for few matches and many") {
  Rng rng(1);
  int told = 0, asked = 0;
  for (const int count : {15, 30, 100, 300, 2000})
    for (const double noise : {0.0, 0.1, 0.35, 0.5, 1.0, 2.0})
      for (const double wrong : {0.0, 0.05})
        for (int trial = 0; trial < 5; ++trial) {
          const TwoViewProblem problem = Turned(count, noise, wrong, rng);
          std::vector<std::uint8_t> inliers;
          const Matrix3Parameters e = AnyEssential(problem, rng, &inliers);
          const ParallaxTest test = TestTurn(problem.normalized, e, inliers);
          ++asked;
          if (test.degeneracy != Degeneracy::kPureRotation) continue;
          ++told;
          REQUIRE(test.pure_rotation);
          CHECK(RotationAngleDegrees(*test.pure_rotation, problem.pose.rotation) <=
                0.4 * noise / std::sqrt(count / 10.0) + 1e-6);
        }
  CHECK(asked == 300);
  CHECK(told >= 297);
}

TEST_CASE("a camera that moved is told whatever the noise, what is far beyond its baseline is not") {
  Rng rng(2);
  for (const double noise : {0.0, 0.5, 2.0})
    for (int trial = 0; trial < 30; ++trial) {
      const TwoViewProblem problem = RandomProblem(60, rng, noise);
      const std::vector<std::uint8_t> all(60, 1);
      Matrix3Parameters e = problem.essential;
      Essential::FitFrom(problem.normalized, Eigen::VectorXd::Ones(60), &e);
      const ParallaxTest test = TestTurn(problem.normalized, e, all);
      CHECK(test.degeneracy == Degeneracy::kDetermined);
      CHECK_FALSE(test.pure_rotation);
    }
}

TEST_CASE("no motion is told from a turn, by what the noise leaves certain") {
  Rng rng(3);
  int still = 0;
  for (const double noise : {0.0, 0.5, 2.0})
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<std::uint8_t> inliers;
      TwoViewProblem problem = Turned(200, noise, 0.05, rng, 0.0);
      Matrix3Parameters e = AnyEssential(problem, rng, &inliers);
      still += TestTurn(problem.normalized, e, inliers).degeneracy == Degeneracy::kStatic;
      problem = Turned(200, noise, 0.05, rng, 0.5);
      e = AnyEssential(problem, rng, &inliers);
      CHECK(TestTurn(problem.normalized, e, inliers).degeneracy == Degeneracy::kPureRotation);
    }
  CHECK(still >= 58);
}

TEST_CASE("what is told of parallax knows no unit, no order of rows and no turn of the images") {
  Rng rng(4);
  for (const double on_plane : {1.0, 0.7})
    for (int trial = 0; trial < 10; ++trial) {
      const auto scene = MakePlanarScene(100, on_plane, 0.0, 0.5, rng);
      const std::vector<std::uint8_t> all(100, 1);
      const Matrix3Parameters f =
          AsParameters(FundamentalFromEssential(EssentialFromPose(scene.views.pose), scene.views.k1, scene.views.k2));
      const Degeneracy expected = on_plane == 1.0 ? Degeneracy::kPlane : Degeneracy::kDetermined;
      const auto told = [&](const PointMatrix& points, const Eigen::Matrix3d& from) {
        const Eigen::Matrix3d inverse = from.inverse();
        return TestPlane(points, AsParameters(inverse.transpose() * AsMatrix(f) * inverse), all).degeneracy;
      };
      const PointMatrix& points = scene.views.pixels;
      CHECK(told(points, Eigen::Matrix3d::Identity()) == expected);
      for (const double unit : {1e-3, 1e6}) {
        Eigen::Matrix3d scale = Eigen::Vector3d(unit, unit, 1.0).asDiagonal();
        CHECK(told(unit * points, scale) == expected);
      }
      CHECK(told(points.colwise().reverse(), Eigen::Matrix3d::Identity()) == expected);
      Eigen::Matrix3d quarter = Eigen::Matrix3d::Zero();
      quarter(0, 1) = -1.0;
      quarter(1, 0) = quarter(2, 2) = 1.0;
      PointMatrix turned(100, 4);
      turned << -points.col(1), points.col(0), -points.col(3), points.col(2);
      CHECK(told(turned, quarter) == expected);
    }
}

TEST_CASE("points beside a line, in any direction and with wrong ones among them") {
  Rng rng(5);
  for (const double angle : {0.0, 0.7, 1.5707963267948966}) {
    PointMatrix points(50, 4);
    for (int i = 0; i < 50; ++i) {
      const double along = rng.Uniform(0.0, 1000.0), across = i < 3 ? 100.0 : 0.5 * rng.Uniform(-1.0, 1.0);
      points.row(i) << along * std::cos(angle) - across * std::sin(angle),
          along * std::sin(angle) + across * std::cos(angle), 0.0, 0.0;
    }
    const std::vector<std::uint8_t> beside = BesideLine(points, 0, std::vector<std::uint8_t>(50, 1), 2.0);
    for (int i = 0; i < 50; ++i) CHECK((beside[i] != 0) == (i < 3));
  }
}

// 340 wrong matches of 400 made a turn of a moving camera, with R off by 7 degrees.
TEST_CASE("wrong matches say nothing of parallax") {
  Rng rng(6);
  for (const double noise : {0.1, 0.8, 2.0})
    for (const int wrong : {0, 60, 240, 1200})
      for (int trial = 0; trial < 5; ++trial) {
        TwoViewProblem problem = RandomProblem(60, rng, noise);
        Matrix3Parameters e = problem.essential;
        Essential::FitFrom(problem.normalized, Eigen::VectorXd::Ones(60), &e);
        const Eigen::RowVectorXd least = problem.normalized.colwise().minCoeff(),
                                 most = problem.normalized.colwise().maxCoeff();
        std::vector<std::uint8_t> inliers(60, 1);
        problem.normalized.conservativeResize(60 + wrong, 4);
        for (int i = 60; i < 60 + wrong; ++i) {
          for (int k = 0; k < 4; ++k) problem.normalized(i, k) = rng.Uniform(least[k], most[k]);
          inliers.push_back(SampsonError(e, problem.normalized.row(i).data()) <= 2.5 * noise / kFocal);
        }
        CAPTURE(noise, wrong, trial);
        CHECK(TestTurn(problem.normalized, e, inliers).degeneracy == Degeneracy::kDetermined);
      }
}

// A photograph that was compressed again had a translation of .08 degrees.
TEST_CASE("errors along rows of pixels are no parallax") {
  Rng rng(7);
  for (int trial = 0; trial < 10; ++trial) {
    const int count = 1000;
    PointMatrix points(count, 4);
    for (int i = 0; i < count; ++i) {
      points.row(i) << rng.Uniform(-0.7, 0.7), rng.Uniform(-0.5, 0.5), 0.0, 0.0;
      points.row(i).tail<2>() = points.row(i).head<2>();
      points(i, 2) += 0.4 / kFocal * rng.Normal();
      points(i, 3) += 0.1 / kFocal * rng.Normal();
      if (i % 50 == 0) points(i, 2) += rng.Uniform(-0.2, 0.2);  // Another window of a row of them.
    }
    const Matrix3Parameters e =
        AsParameters(EssentialFromPose({Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitX()}));
    const std::vector<std::uint8_t> all(count, 1);
    CHECK(TestTurn(points, e, all).degeneracy == Degeneracy::kStatic);
    for (int i = 0; i < count; i += 10) points(i, 2) += rng.Uniform(0.01, 0.05);  // Near things, all to one side.
    CHECK(TestTurn(points, e, all).degeneracy == Degeneracy::kDetermined);
  }
}

TEST_CASE("turns are found with two unknown focal lengths") {
  Rng rng(8);
  for (int trial = 0; trial < 10; ++trial) {
    TwoViewProblem problem = Turned(200, 0.3, 0.0, rng);
    problem.normalized.leftCols(2) *= 1.5;
    problem.normalized.rightCols(2) *= 0.8;
    Eigen::Vector2d factors;
    const std::vector<std::uint8_t> all(200, 1);
    REQUIRE(FindFocalsOfTurn(problem.normalized, all, TurnFocals::kEach, &factors));
    PointMatrix points = problem.normalized;
    points.leftCols(2) /= factors[0];
    points.rightCols(2) /= factors[1];
    const Matrix3Parameters e = AsParameters(EssentialFromPose({problem.pose.rotation, RandomDirection(rng)}));
    CHECK(TestTurn(points, e, all).degeneracy == Degeneracy::kPureRotation);
  }
}

TEST_CASE("what shows nothing is not tested") {
  const Matrix3Parameters e = AsParameters(EssentialFromPose({}));
  CHECK(TestTurn(PointMatrix(0, 4), e, {}).degeneracy == Degeneracy::kNotTested);
  CHECK(TestTurn(PointMatrix::Zero(5, 4), e, {1, 1, 1, 1, 1}).degeneracy == Degeneracy::kNotTested);
  CHECK(TestTurn(PointMatrix::Constant(5, 4, std::nan("")), e, {1, 1, 1, 1, 1}).degeneracy == Degeneracy::kNotTested);
  CHECK(TestPlane(PointMatrix::Random(5, 4), e, {1, 0, 0, 0, 0}).degeneracy == Degeneracy::kNotTested);
}

}  // namespace diffsac
