#include "diffsac/geometry/pose.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography_decomposition.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

using testing::ModelDistance;
using testing::RandomPose;
using testing::RandomProblem;

double PoseError(const RelativePose& a, const RelativePose& b) {
  return std::max(RotationAngleDegrees(a.rotation, b.rotation), DirectionAngleDegrees(a.translation, b.translation));
}

TEST_CASE("Pose to E to pose, and the four poses are rotations with the same E") {
  Rng rng(1);
  for (int trial = 0; trial < 500; ++trial) {
    const auto problem = RandomProblem(20, rng);
    const Eigen::Matrix3d e = AsMatrix(problem.essential);
    for (const RelativePose& pose : DecomposeEssential(e)) {
      CHECK((pose.rotation * pose.rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-13);
      CHECK(pose.rotation.determinant() == Approx(1.0));
      CHECK(pose.translation.norm() == Approx(1.0));
      CHECK(ModelDistance(AsParameters(EssentialFromPose(pose)), problem.essential) < 1e-13);
    }
    for (const double sign : {1.0, -1.0}) {
      const PoseChoice choice = ChoosePose(sign * e, problem.normalized);
      REQUIRE(choice.status == Status::kOk);
      CHECK(choice.in_front == 20);
      CHECK(choice.runner_up < 20);
      CHECK(PoseError(choice.pose, problem.pose) < 1e-6);
    }
  }
}

TEST_CASE("Only the inliers decide about the pose") {
  Rng rng(2);
  auto problem = RandomProblem(30, rng);
  std::vector<std::uint8_t> inliers(30, 1);
  for (int i = 0; i < 20; ++i) {
    inliers[i] = 0;
    problem.normalized(i, 0) = std::nan("");
  }
  const PoseChoice choice = ChoosePose(AsMatrix(problem.essential), problem.normalized, inliers);
  REQUIRE(choice.status == Status::kOk);
  CHECK(choice.in_front == 10);
  CHECK(PoseError(choice.pose, problem.pose) < 1e-6);
}

TEST_CASE("A pose that points cannot decide about is typed") {
  Rng rng(3);
  const auto problem = RandomProblem(10, rng);
  const Eigen::Matrix3d e = AsMatrix(problem.essential);
  CHECK(ChoosePose(e, PointMatrix(0, 4)).status == Status::kTooFewPoints);
  CHECK(ChoosePose(e, problem.normalized, std::vector<std::uint8_t>(10, 0)).status == Status::kTooFewPoints);
  CHECK(ChoosePose(e, problem.normalized.leftCols<2>()).status == Status::kDegenerate);
  CHECK(ChoosePose(Eigen::Matrix3d::Zero(), problem.normalized).status == Status::kDegenerate);
  CHECK(ChoosePose(Eigen::Matrix3d::Constant(std::nan("")), problem.normalized).status == Status::kDegenerate);
  PointMatrix bad = problem.normalized;
  bad(0, 0) = std::nan("");
  CHECK(ChoosePose(e, bad).status == Status::kDegenerate);

  // Points at infinity lie before no camera: the rays are parallel.
  PointMatrix parallel(3, 4);
  parallel << 0, 0, 0, 0, 0.1, 0.2, 0.1, 0.2, -0.3, 0.1, -0.3, 0.1;
  const RelativePose sideways{Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitX()};
  CHECK(ChoosePose(EssentialFromPose(sideways), parallel).status == Status::kNoModel);

  // One point before both cameras, one that only the opposite motion puts there: a tie.
  PointMatrix tie(2, 4);
  tie << 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, -0.1, 0.1;
  const PoseChoice choice = ChoosePose(EssentialFromPose(sideways), tie);
  CHECK(choice.status == Status::kDegenerate);
  CHECK(choice.in_front == 1);
  CHECK(choice.runner_up == 1);
}

TEST_CASE("F with K to E and back, and pixels to normalised coordinates") {
  Rng rng(4);
  for (int trial = 0; trial < 100; ++trial) {
    const auto problem = RandomProblem(5, rng);
    const Eigen::Matrix3d e = EssentialFromFundamental(AsMatrix(problem.fundamental), problem.k1, problem.k2);
    CHECK(ModelDistance(AsParameters(e), problem.essential) < 1e-12);
    for (int i = 0; i < 5; ++i) {
      CHECK(Essential::Residual(problem.essential, problem.normalized.data() + 4 * i) < 1e-13);
      CHECK(SampsonError(problem.fundamental, problem.pixels.data() + 4 * i) < 1e-9);
    }
  }
}

TEST_CASE("Only points that are behind by more than noise cannot be in front") {
  Rng rng(7);
  constexpr double kNoise = 1e-3;
  for (int trial = 0; trial < 500; ++trial) {
    const RelativePose pose = RandomPose(rng), opposite{pose.rotation, -pose.translation};
    const auto point_at = [&](double depth) {
      const Eigen::Vector3d first = depth * Eigen::Vector3d(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.5, 0.5), 1.0);
      const Eigen::Vector3d second = pose.rotation * first + pose.translation;
      return Eigen::Vector4d(first[0] / first[2], first[1] / first[2], second[0] / second[2], second[1] / second[2]);
    };
    const Eigen::Vector4d near = point_at(rng.Uniform(3.0, 8.0)), far = point_at(1e4);
    CHECK(PassesCheirality(pose, near.data(), kNoise));
    CHECK(PassesCheirality(pose, far.data(), kNoise));
    CHECK(PassesCheirality(opposite, far.data(), kNoise));
    CHECK_FALSE(PassesCheirality(opposite, far.data(), 1e-7));
    // What is seen along the baseline may be anywhere.
    const Eigen::Vector3d a = pose.rotation * near.head<2>().homogeneous(), b = near.tail<2>().homogeneous();
    const double parallax = std::min(a.cross(b).norm() / (a.norm() * b.norm()),
                                     std::min(a.cross(pose.translation).norm(), b.cross(pose.translation).norm()));
    if (parallax > 0.05) CHECK_FALSE(PassesCheirality(opposite, near.data(), kNoise));
  }
  // Towards the epipole, the noise of an image may put the point on either side of it.
  const RelativePose forward{Eigen::Matrix3d::Identity(), -Eigen::Vector3d::UnitZ()};
  const double across[] = {-2e-4, 0.0, 3e-4, 0.0};
  CHECK_FALSE(InFront(forward, across));
  CHECK(PassesCheirality(forward, across, kNoise));
}

TEST_CASE("Far points that are all on the wrong side do not choose the sign of t") {
  // The rotation is off by 1e-4, so that 300 far points come out behind; 60 near ones see what is right.
  const RelativePose truth{Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitX()};
  const Eigen::Matrix3d off = Eigen::AngleAxisd(1e-4, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Rng rng(8);
  PointMatrix points(360, 4);
  for (int i = 0; i < 360; ++i) {
    const double x = rng.Uniform(-0.5, 0.5), y = rng.Uniform(-0.4, 0.4);
    points.row(i) << x, y, x + (i < 60 ? 0.1 : 0.0), y;
  }
  const Eigen::Matrix3d e = EssentialFromPose({off, truth.translation});
  CHECK(ChoosePose(e, points).pose.translation[0] < 0.0);
  const PoseChoice choice = ChoosePose(e, points, {}, 1e-3);
  CHECK(choice.status == Status::kOk);
  CHECK(choice.pose.translation[0] > 0.0);
  CHECK(choice.in_front == 60);
  CHECK(choice.runner_up == 300);
}

TEST_CASE("Angles of rotations and directions keep their digits at both ends") {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  const Eigen::Matrix3d start = Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.2, 1, 3).normalized()).toRotationMatrix();
  for (const double degrees : {0.0, 1e-6, 0.5, 30.0, 90.0, 179.0, 179.9999, 180.0}) {
    const double radians = degrees * 3.14159265358979323846 / 180.0;
    const Eigen::Matrix3d end = start * Eigen::AngleAxisd(radians, axis).toRotationMatrix();
    CHECK(RotationAngleDegrees(start, end) == Approx(degrees).epsilon(1e-7).margin(1e-13));
    const Eigen::Vector3d a(2, 0, 0), b(3 * std::cos(radians), 3 * std::sin(radians), 0);
    CHECK(DirectionAngleDegrees(a, b) == Approx(degrees).epsilon(1e-9).margin(1e-13));
  }
  CHECK(std::isnan(DirectionAngleDegrees(Eigen::Vector3d::Zero(), axis)));
}

TEST_CASE("A homography's decomposition holds the true motion and plane, visibility leaves at most two") {
  Rng rng(7);
  for (int trial = 0; trial < 1000; ++trial) {
    PlaneMotion truth;
    truth.rotation = RandomPose(rng).rotation;
    truth.translation = rng.Uniform(0.05, 0.6) * testing::RandomDirection(rng);
    truth.normal = Eigen::Vector3d(rng.Uniform(-0.5, 0.5), rng.Uniform(-0.5, 0.5), 1.0).normalized();
    const Eigen::Matrix3d k1 = testing::RandomCamera(rng), k2 = testing::RandomCamera(rng);
    const Eigen::Matrix3d h =
        k2 * (truth.rotation + truth.translation * truth.normal.transpose()) * k1.inverse() * rng.Uniform(-3.0, 3.0);
    const PlaneMotions motions = DecomposeHomography(h, k1, k2);
    REQUIRE(motions.count == 4);
    double best = 1e9;
    for (int i = 0; i < 4; ++i) {
      const PlaneMotion& m = motions.motions[i];
      best = std::min(best, (m.rotation - truth.rotation).norm() + (m.translation - truth.translation).norm() +
                                (m.normal - truth.normal).norm());
      CHECK(m.normal.norm() == Approx(1.0));
      CHECK(m.rotation.determinant() == Approx(1.0));
      const Eigen::Matrix3d again = k2 * (m.rotation + m.translation * m.normal.transpose()) * k1.inverse();
      CHECK(ModelDistance(AsParameters(again), AsParameters(h)) < 1e-9);
    }
    CHECK(best < 1e-6);
    PointMatrix points(10, 4);
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d ray(rng.Uniform(-0.4, 0.4), rng.Uniform(-0.4, 0.4), 1.0);
      points.row(i) << (k1 * ray).hnormalized().transpose(), 0.0, 0.0;
    }
    const PlaneMotions visible = KeepVisible(motions, points, k1);
    CHECK(visible.count >= 1);
    CHECK(visible.count <= 2);
  }
}

TEST_CASE("Homographies of a rotation alone and bad ones") {
  Rng rng(8);
  const Eigen::Matrix3d k = testing::RandomCamera(rng), rotation = RandomPose(rng).rotation;
  const PlaneMotions turned = DecomposeHomography(-2.0 * k * rotation * k.inverse(), k, k);
  REQUIRE(turned.count == 1);
  CHECK((turned.motions[0].rotation - rotation).norm() < 1e-9);
  CHECK(turned.motions[0].translation.norm() == 0.0);
  CHECK(KeepVisible(turned, PointMatrix::Ones(3, 4), k).count == 1);
  CHECK(DecomposeHomography(Eigen::Matrix3d::Zero(), k, k).count == 0);
  CHECK(DecomposeHomography(Eigen::Matrix3d::Constant(std::nan("")), k, k).count == 0);
  CHECK(DecomposeHomography(Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero(), k).count == 0);
}

}  // namespace
}  // namespace diffsac
