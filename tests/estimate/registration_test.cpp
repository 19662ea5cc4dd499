// Motions between clouds: what is found, how certain, and what is said where nothing is.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/errors.h"
#include "diffsac/diffsac.h"
#include "diffsac/estimate/classical.h"
#include "diffsac/estimate/cloud_resolution.h"
#include "diffsac/estimate/presets.h"
#include "diffsac/geometry/motion_errors.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/chance_share.h"
#include "diffsac/problem/tasks.h"
#include "estimate/owned_matches.h"
#include "geometry/cloud_scene.h"
#include "geometry/normalized_errors.h"

namespace diffsac {
namespace {

using testing::CloudScene;
using testing::MakeCloudScene;

constexpr double kChiSquare95Of6 = 12.592, kChiSquare95Of7 = 14.067;

testing::OwnedMatches3D3D MatchesOf(const PointMatrix& points) { return {points.leftCols(3), points.rightCols(3)}; }

RigidMotionEstimate Rigidly(const PointMatrix& points, double allowed = 0.05) {
  return EstimateRigidMotion(MatchesOf(points), RegistrationOptions{.max_residual = allowed});
}

double DegreesOff(const RigidMotion& motion, const Rigid::Parameters& truth) {
  return RotationAngleDegrees(motion.rotation, RotationOf(truth));
}

/// ωᵀ … of [s R | t], in the order of the covariances.
Eigen::VectorXd MotionError(const Rigid::Parameters& truth, const Eigen::Matrix<double, 3, 4>& model, int size) {
  const double scale = ScaleOf(truth), found = std::cbrt(model.leftCols<3>().determinant());
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(RotationOf(truth) / scale * model.leftCols<3>().transpose() / found));
  Eigen::VectorXd error(size);
  error.head<3>() = turn.angle() * turn.axis();
  error.segment<3>(3) = TranslationOf(truth) - model.col(3);
  if (size == 7) error[6] = std::log(scale / found);
  return error;
}

PointMatrix WithRows(const PointMatrix& points, const PointMatrix& more) {
  PointMatrix all(points.rows() + more.rows(), 6);
  all << points, more;
  return all;
}

/// The default distance is near that of the scene alone.
template <class Result>
Result CheckDistance(Result (*estimate)(const Matches3D3D&, const RegistrationOptions&), const CloudScene& scene,
                     const PointMatrix& points, double nearness) {
  const double alone = estimate(MatchesOf(scene.points), {}).inlier_threshold;
  Result found = estimate(MatchesOf(points), {});
  REQUIRE(found.ok());
  CHECK(found.inlier_threshold < nearness * alone);
  CHECK(found.inlier_threshold > alone / nearness);
  return found;
}

/// And the motion is right. shrinks: where more matches end in one place than are right, a similarity may shrink the
/// cloud to that place, whatever distance is given.
void CheckDefaults(const CloudScene& scene, const PointMatrix& points, double nearness, bool shrinks = false) {
  const auto rigid = CheckDistance(&EstimateRigidMotion, scene, points, nearness);
  CHECK_FALSE(testing::MayBeChance(rigid));
  CHECK(DegreesOff(*rigid.pose, scene.truth) < 0.3);
  const auto similar = CheckDistance(&EstimateSimilarity, scene, points, nearness);
  if (shrinks) return;
  CHECK_FALSE(testing::MayBeChance(similar));
  CHECK(DegreesOff(*similar.pose, scene.truth) < 0.3);
}

}  // namespace

TEST_CASE("a motion is found where one match of a hundred is right, and random matches may be chance") {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const CloudScene scene = MakeCloudScene(3000, 0.985, 0.01, Rng(1).Fork("scene", seed));
    const RigidMotionEstimate estimate = Rigidly(scene.points);
    CAPTURE(seed, estimate.num_inliers, estimate.diagnostics.log10_nfa);
    REQUIRE(estimate.ok());
    CHECK_FALSE(testing::MayBeChance(estimate));
    CHECK(DegreesOff(*estimate.pose, scene.truth) < 1.0);
    CHECK(estimate.sigma == Approx(0.01).epsilon(0.4));
    const RigidMotionEstimate chance = Rigidly(MakeCloudScene(3000, 1.0, 0.01, Rng(2).Fork("scene", seed)).points);
    CHECK((!chance.ok() || testing::MayBeChance(chance)));
  }
}

TEST_CASE("too few matches, one line, one place, values that are not finite and mirrored clouds are told") {
  const CloudScene scene = MakeCloudScene(40, 0.0, 0.001, Rng(3));
  for (int count = 0; count < 3; ++count) CHECK(Rigidly(scene.points.topRows(count)).status == Status::kTooFewPoints);
  const RigidMotionEstimate three = Rigidly(scene.points.topRows(3));
  CHECK((!three.ok() || testing::MayBeChance(three)));
  const RigidMotionEstimate four = Rigidly(scene.points.topRows(4));
  CHECK((!four.ok() || DegreesOff(*four.pose, scene.truth) < 5.0));
  PointMatrix line = scene.points;
  for (Eigen::Index i = 0; i < line.rows(); ++i) line.row(i) = scene.points.row(0) + i * scene.points.row(1);
  CHECK(Rigidly(line).status == Status::kDegenerate);
  CHECK(Rigidly(scene.points.row(0).replicate(40, 1)).status == Status::kDegenerate);
  PointMatrix broken = scene.points;
  broken.col(4).setConstant(std::numeric_limits<double>::quiet_NaN());
  CHECK(Rigidly(broken).status == Status::kTooFewPoints);
  CHECK(Rigidly(broken).diagnostics.num_nonfinite == 40);
  PointMatrix mirrored = scene.points;
  mirrored.col(1) *= -1.0;
  const RigidMotionEstimate wrong = Rigidly(mirrored);
  CHECK((!wrong.ok() || testing::MayBeChance(wrong)));
  // One plane determines a motion.
  const CloudScene flat = MakeCloudScene(100, 0.3, 0.005, Rng(4), 1.0, 0.0);
  CHECK(DegreesOff(*Rigidly(flat.points).pose, flat.truth) < 1.0);
}

TEST_CASE("options of clouds that make no sense, and unlike lengths, are errors that name them") {
  const testing::OwnedMatches3D3D matches = MatchesOf(MakeCloudScene(10, 0.0, 0.01, Rng(5)).points);
  for (const double wrong : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")})
    CHECK(ErrorOf([&] {
            EstimateRigidMotion(matches, RegistrationOptions{.max_residual = wrong});
          }).starts_with("max_residual: "));
  testing::OwnedMatches3D3D unlike = matches;
  unlike.points2.conservativeResize(9, 3);
  CHECK(ErrorOf([&] { EstimateSimilarity(unlike); }).starts_with("points2: expected as many rows as points1"));
}

TEST_CASE("a thing that looks the same after half a turn has two motions, and one that does not has one") {
  int told = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    CloudScene scene = MakeCloudScene(400, 0.3, 0.005, Rng(6).Fork("scene", seed));
    const RigidMotionEstimate one = Rigidly(scene.points);
    CHECK_FALSE(one.ambiguous_pose.has_value());
    CHECK(one.pose_covariance);
    // Every second match is to where it would be after half a turn about the third axis.
    for (Eigen::Index i = 1; i < 400; i += 2) scene.points.row(i).head<2>() *= -1.0;
    const RigidMotionEstimate two = Rigidly(scene.points);
    REQUIRE(two.ok());
    told += two.ambiguous_pose.has_value() ? 1 : 0;
    if (!two.ambiguous_pose.has_value()) continue;
    CHECK_FALSE(two.pose_covariance);
    CHECK(RotationAngleDegrees(two.pose->rotation, two.ambiguous_pose->rotation) > 179.0);
    CHECK(std::min(DegreesOff(*two.pose, scene.truth), DegreesOff(*two.ambiguous_pose, scene.truth)) < 1.0);
  }
  CHECK(told >= 9);
}

TEST_CASE("turning and moving either cloud turns the motion and changes nothing else") {
  const CloudScene scene = MakeCloudScene(300, 0.6, 0.01, Rng(9));
  const RigidMotionEstimate one = Rigidly(scene.points);
  for (std::uint64_t seed = 0; seed < 5; ++seed)
    for (const int side : {0, 3}) {
      const Rigid::Parameters change = MakeCloudScene(1, 0.0, 0.0, Rng(10).Fork("turn", seed)).truth;
      PointMatrix points = scene.points;
      points.middleCols(side, 3) =
          (points.middleCols(side, 3) * RotationOf(change).transpose()).rowwise() + TranslationOf(change).transpose();
      const RigidMotionEstimate turned = Rigidly(points);
      const Eigen::Matrix3d expected = side == 0 ? Eigen::Matrix3d(one.pose->rotation * RotationOf(change).transpose())
                                                 : Eigen::Matrix3d(RotationOf(change) * one.pose->rotation);
      CHECK(turned.inliers == one.inliers);
      CHECK((turned.pose->rotation - expected).norm() < 1e-5);
      CHECK(turned.sigma == Approx(one.sigma).epsilon(1e-4));
    }
}

TEST_CASE("very many matches far from the origin give the motion") {
  CloudScene scene = MakeCloudScene(110'000, 0.5, 0.01, Rng(13));
  const Eigen::RowVector3d far(4e6, -5e6, 3e4);
  scene.points.leftCols(3).rowwise() += far;
  const RigidMotionEstimate estimate = Rigidly(scene.points);
  REQUIRE(estimate.ok());
  CHECK(DegreesOff(*estimate.pose, scene.truth) < 0.01);
  CHECK((estimate.pose->rotation * far.transpose() + estimate.pose->translation - TranslationOf(scene.truth)).norm() <
        0.01);
}

TEST_CASE("errors of motions between clouds are what their covariances say", "[covariance]") {
  for (const bool scaled : {false, true}) {
    testing::NormalizedErrors errors;
    const int size = scaled ? 7 : 6;
    for (int i = 0; i < 200; ++i) {
      const CloudScene scene = MakeCloudScene(150, 0.5, 0.01, Rng(7).Fork("scene", i), scaled ? 3.0 : 1.0);
      const testing::OwnedMatches3D3D matches = MatchesOf(scene.points);
      const auto add = [&](const auto& estimate) {
        REQUIRE(estimate.pose_covariance);
        errors.values.push_back(
            testing::NormalizedError(MotionError(scene.truth, estimate.model, size), *estimate.pose_covariance, size));
      };
      if (scaled)
        add(EstimateSimilarity(matches, RegistrationOptions{.max_residual = 0.05}));
      else
        add(EstimateRigidMotion(matches, RegistrationOptions{.max_residual = 0.05}));
    }
    CAPTURE(scaled, errors.Mean());
    CHECK(errors.Mean() > 0.85 * size);
    CHECK(errors.Mean() < 1.25 * size);
    CHECK(errors.ShareBeyond(scaled ? kChiSquare95Of7 : kChiSquare95Of6) < 0.12);
  }
}

TEST_CASE("things that move by themselves have a motion each, far from the origin as well") {
  Rng rng(31);
  const CloudScene first = MakeCloudScene(600, 0.0, 0.01, rng.Fork("first")),
                   second = MakeCloudScene(400, 0.0, 0.01, rng.Fork("second")),
                   wrong = MakeCloudScene(2000, 1.0, 0.01, rng.Fork("wrong"));
  PointMatrix points(3000, 6);
  points << first.points, second.points, wrong.points;
  const Eigen::RowVector3d far(1e5, -2e5, 3e4);
  points.leftCols(3).rowwise() += far;
  const auto found = EstimateMultipleRigidMotions(MatchesOf(points), RegistrationOptions{.max_residual = 0.05});
  REQUIRE(found.ok());
  REQUIRE(found.models.size() == 2);
  for (int k = 0; k < 2; ++k) {
    const Rigid::Parameters& truth = k == 0 ? first.truth : second.truth;
    const Eigen::Matrix3d rotation = found.models[k].leftCols<3>();
    CHECK((rotation - RotationOf(truth)).norm() < 0.02);
    CHECK((rotation * far.transpose() + found.models[k].col(3) - TranslationOf(truth)).norm() < 0.02);
  }
  const auto of = [&](int begin, int end, int label) {
    return std::count(found.assignment.begin() + begin, found.assignment.begin() + end, label);
  };
  CHECK(of(0, 600, 1) > 570);
  CHECK(of(600, 1000, 2) > 380);
  CHECK(of(1000, 3000, 0) > 1950);
  CHECK_FALSE(EstimateMultipleRigidMotions(MatchesOf(wrong.points), RegistrationOptions{.max_residual = 0.05}).ok());
  CHECK(EstimateMultipleRigidMotions({PointMatrix(0, 3), PointMatrix(0, 3)}, RegistrationOptions{.max_residual = 0.05})
            .status == Status::kTooFewPoints);
}

TEST_CASE("of chance, points that many are matched to and neighbours that are matched alike say nothing more") {
  const CloudScene scene = MakeCloudScene(2000, 0.97, 0.01, Rng(21));
  const double alone = Rigidly(scene.points).diagnostics.log10_nfa;
  REQUIRE(alone < -10.0);
  PointMatrix hubs = scene.points;  // Of the wrong ones, the first: five of six are matched to twenty places.
  for (Eigen::Index i = 0; i < 1600; ++i) hubs.row(i).tail(3) = scene.points.row(i % 20).tail(3);
  CHECK(Rigidly(hubs).diagnostics.log10_nfa < alone + 5.0);
  Rng rng(22);
  PointMatrix crowd = scene.points.replicate(5, 1);
  for (double& value : crowd.reshaped()) value += 1e-4 * rng.Normal();
  CHECK(Rigidly(crowd).diagnostics.log10_nfa == Approx(alone).epsilon(0.4));
  // Of three wrong matches that agree, each with twenty neighbours, no motion is made.
  PointMatrix wrong = MakeCloudScene(600, 1.0, 0.01, Rng(23)).points;
  PointMatrix agree = scene.points.bottomRows(3).replicate(20, 1);
  for (double& value : agree.reshaped()) value += 0.005 * rng.Normal();
  wrong.topRows(60) = agree;
  const RigidMotionEstimate estimate = Rigidly(wrong);
  REQUIRE(estimate.ok());
  CHECK(testing::MayBeChance(estimate));
}

TEST_CASE("the share of a cloud's places that a ball takes is of the volume that it occupies") {
  Rng rng(8);
  PointMatrix box(20000, 3), plane(20000, 3);
  for (Eigen::Index i = 0; i < box.rows(); ++i) {
    for (int axis = 0; axis < 3; ++axis) box(i, axis) = rng.Uniform(0.0, 10.0);
    plane.row(i) = box.row(i);
    plane(i, 2) = 0.0;
  }
  CHECK(OccupiedShare(box, 0.5) == Approx(4.18879 * 0.125 / 1000.0).epsilon(0.15));
  CHECK(OccupiedShare(plane, 0.5) > 10.0 * OccupiedShare(box, 0.5));
  CHECK(OccupiedShare(box, 1e3) == 1.0);
  CHECK(OccupiedShare(box, 1e-9) < 1e-6);
  CHECK(OccupiedShare(PointMatrix::Zero(5, 3), 0.1) == 1.0);
  CHECK(OccupiedShare(PointMatrix::Zero(1, 3), 0.1) == 1.0);
}

TEST_CASE("many matches to one place leave the default distance") {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    Rng rng = Rng(41).Fork("scene", seed);
    const CloudScene scene = MakeCloudScene(450, 0.6, 0.01, rng.Fork("scene"));
    for (const double share : {0.3, 0.5, 0.7})
      for (const int hubs : {1, 5}) {
        CAPTURE(seed, share, hubs);
        PointMatrix more(std::lround(450 * share / (1.0 - share)), 6);
        const PointMatrix places = PointMatrix::NullaryExpr(hubs, 3, [&] { return rng.Uniform(-1.0, 1.0); });
        for (Eigen::Index i = 0; i < more.rows(); ++i)
          for (int k = 0; k < 3; ++k) {
            more(i, k) = rng.Uniform(-2.0, 2.0);
            more(i, 3 + k) = places(i % hubs, k) + 0.004 * rng.Normal();
          }
        CheckDefaults(scene, WithRows(scene.points, more), 1.5, more.rows() >= 180 * hubs);
      }
  }
}

TEST_CASE("invalid returns and repeated rows leave the default distance") {
  const CloudScene scene = MakeCloudScene(450, 0.6, 0.01, Rng(42));
  for (const int returns : {1, 200, 440, 460, 700}) {
    CAPTURE(returns);
    CheckDefaults(scene, WithRows(scene.points, PointMatrix::Zero(returns, 6)), 1.02);
  }
  const double one = EstimateRigidMotion(MatchesOf(scene.points)).inlier_threshold;
  const PointMatrix thrice = scene.points.replicate(3, 1), reversed = scene.points.colwise().reverse();
  for (const PointMatrix& points : {thrice, reversed, WithRows(scene.points, scene.points.topRows(100))})
    CHECK(EstimateRigidMotion(MatchesOf(points)).inlier_threshold == one);
  for (const double unit : {1e-3, 3.0, 1e6})
    CHECK(EstimateRigidMotion(MatchesOf(unit * scene.points)).inlier_threshold == Approx(unit * one));
}

TEST_CASE("the resolution of a cloud is the spacing of its places") {
  PointMatrix grid(900, 3);
  for (Eigen::Index i = 0; i < 900; ++i) grid.row(i) << static_cast<double>(i % 30), static_cast<double>(i / 30), 5.0;
  CHECK(CloudResolution(0.2 * grid) == Approx(0.2));
  CHECK(CloudResolution(grid.topRows(2)) == Approx(1.0));
  CHECK(CloudResolution(grid.topRows(1).replicate(9, 1)) == 0.0);
  CHECK(CloudResolution(PointMatrix(0, 3)) == 0.0);
  PointMatrix broken = grid;
  broken.topRows(300).col(1).setConstant(std::nan(""));
  CHECK(CloudResolution(broken) == Approx(1.0));
  Rng rng(43);
  PointMatrix crowd = grid.replicate(5, 1);
  for (double& value : crowd.reshaped()) value += 1e-3 * rng.Normal();
  CHECK(CloudResolution(crowd) == Approx(1.0).epsilon(0.02));
}

TEST_CASE("covariances of far clouds are of the t given") {
  const Eigen::RowVector3d far(331250.0, 5712480.0, 105.0);
  const CloudScene scene = MakeCloudScene(300, 0.5, 0.01, Rng(44));
  PointMatrix moved = scene.points;
  moved.leftCols(3).rowwise() += far;
  moved.rightCols(3).rowwise() += 0.3 * far;
  const auto check = [&](const auto& near, const auto& there) {
    REQUIRE(near.pose_covariance);
    REQUIRE(there.pose_covariance);
    const auto size = near.pose_covariance->rows();
    // t of the near clouds, R far + t of the far ones: the same place.
    const Eigen::MatrixXd change = ErrorsFromOrigin(-there.model.template leftCols<3>() * far.transpose(), size),
                          back = change * *there.pose_covariance * change.transpose();
    CHECK((back - *near.pose_covariance).norm() < 0.02 * near.pose_covariance->norm());
    const double turned = std::sqrt(near.pose_covariance->template topLeftCorner<3, 3>().trace());
    CHECK(std::sqrt(there.pose_covariance->template block<3, 3>(3, 3).trace()) > 0.3 * turned * far.norm());
    const Eigen::Vector3d truth =
        TranslationOf(scene.truth) - RotationOf(scene.truth) * far.transpose() + 0.3 * far.transpose();
    CHECK((truth - there.model.col(3)).norm() <
          4.0 * std::sqrt(there.pose_covariance->template block<3, 3>(3, 3).trace()));
  };
  check(EstimateRigidMotion(MatchesOf(scene.points), RegistrationOptions{.max_residual = 0.05}),
        EstimateRigidMotion(MatchesOf(moved), RegistrationOptions{.max_residual = 0.05}));
  check(EstimateSimilarity(MatchesOf(scene.points), RegistrationOptions{.max_residual = 0.05}),
        EstimateSimilarity(MatchesOf(moved), RegistrationOptions{.max_residual = 0.05}));
}

}  // namespace diffsac
