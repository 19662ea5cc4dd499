#include "diffsac/geometry/shared_focal.h"

#include <catch2/catch.hpp>
#include <limits>

#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/sampson_equations.h"
#include "geometry/jacobian_check.h"
#include "geometry/unknown_focal_scene.h"

namespace diffsac {
namespace {

using testing::FocalModelDistance;
using testing::MakeUnknownFocalScene;
using testing::Motion;
using testing::UnknownFocalScene;

constexpr UnknownFocal kBoth = UnknownFocal::kBoth, kSecond = UnknownFocal::kSecond;

template <class Manifold>
void CheckTangent(const FocalParameters& model, const double* point) {
  const Manifold state = Manifold::From(model);
  const auto parameters = [&](const Eigen::VectorXd& step) {
    return Eigen::VectorXd(state.Retract(typename Manifold::Step(step)).Parameters());
  };
  testing::CheckJacobian(parameters, Eigen::VectorXd::Zero(Manifold::kFreedom), state.Tangent());
  // And the residual's derivative by E and log f, through F.
  const auto residual = [&](const Eigen::VectorXd& step) {
    const Matrix3Parameters f = state.Retract(typename Manifold::Step(step)).Parameters();
    return Eigen::VectorXd::Constant(1, SampsonResidual(f.data(), point, nullptr)).eval();
  };
  Matrix3Parameters gradient;
  SampsonResidual(state.Parameters().data(), point, gradient.data());
  testing::CheckJacobian(residual, Eigen::VectorXd::Zero(Manifold::kFreedom), gradient.transpose() * state.Tangent());
}

/// Starts from a model that is off by a few hundredths.
FocalParameters Disturbed(const FocalParameters& model, Rng& rng) {
  Eigen::Matrix<double, 6, 1> step;
  for (double& value : step) value = 0.03 * rng.Normal();
  return FocalManifold<kBoth, false>::From(model).Retract(step).Model();
}

template <class Model>
void CheckFits(UnknownFocal unknown) {
  Rng rng(4);
  for (int trial = 0; trial < 20; ++trial) {
    CAPTURE(trial);
    const UnknownFocalScene scene = MakeUnknownFocalScene(unknown, 60, rng);
    FocalParameters model;
    REQUIRE(Model::Fit(scene.points, Eigen::VectorXd::Ones(60), &model));
    CHECK(FocalModelDistance(model, scene.model) < 1e-3);
    // The prior weighs as the residuals do at the start: nothing at the true model.
    model = Disturbed(scene.model, rng);
    for (int round = 0; round < 3; ++round) REQUIRE(Model::FitFrom(scene.points, Eigen::VectorXd::Ones(60), &model));
    CHECK(FocalModelDistance(model, scene.model) < 1e-3);
    model = Disturbed(scene.model, rng);
    for (int round = 0; round < 3; ++round)
      Model::Refine(scene.points, Eigen::VectorXd::Ones(60), {LossKind::kTruncated, 0.1}, &model);
    CHECK(FocalModelDistance(model, scene.model) < 1e-3);
  }
}

}  // namespace

TEST_CASE("the tangents of unknown focal lengths are derivatives") {
  Rng rng(1);
  for (int trial = 0; trial < 5; ++trial) {
    const UnknownFocalScene scene = MakeUnknownFocalScene(kBoth, 1, rng, 0.05);
    CheckTangent<FocalManifold<kBoth, false>>(scene.model, scene.points.data());
    CheckTangent<FocalManifold<kBoth, true>>(scene.model, scene.points.data());
    CheckTangent<FocalManifold<kSecond, false>>(scene.model, scene.points.data());
    CheckTangent<FocalManifold<kSecond, true>>(scene.model, scene.points.data());
  }
}

TEST_CASE("the prior's share of the normal equations is its penalty's derivative") {
  Rng rng(2);
  FocalManifold<kBoth, false> state = FocalManifold<kBoth, false>::From(MakeUnknownFocalScene(kBoth, 1, rng).model);
  state.prior_weight = 3.0;
  state.log_median = 0.2;
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  state.AddPenalty(&normal, &gradient);
  const auto penalty = [&](const Eigen::VectorXd& step) {
    return Eigen::VectorXd::Constant(1, state.Retract(Eigen::Matrix<double, 6, 1>(step)).Penalty()).eval();
  };
  testing::CheckJacobian(penalty, Eigen::VectorXd::Zero(6), 2.0 * gradient.transpose());
  CHECK(normal(5, 5) == 3.0);
  CHECK(normal.sum() == 3.0);
}

TEST_CASE("minimal sets give the true model, and with the right focal length assumed five points do on a plane") {
  Rng rng(3);
  int found = 0, on_plane = 0;
  const int set[] = {0, 1, 2, 3, 4, 5};
  constexpr int kTrials = 300;
  for (int trial = 0; trial < kTrials; ++trial) {
    FocalParameters models[SharedFocal::kMaxSolutions];
    const UnknownFocalScene scene = MakeUnknownFocalScene(kBoth, 6, rng);
    const auto best = [&](const UnknownFocalScene& of, int count) {
      double least = 9.0;
      for (int k = 0; k < count; ++k) least = std::min(least, FocalModelDistance(models[k], of.model));
      return least;
    };
    found += best(scene, SharedFocal::SolveMinimal(scene.points, set, models)) < 1e-6 ? 1 : 0;
    UnknownFocalScene plane = MakeUnknownFocalScene(kBoth, 6, rng, 0.0, Motion::kAny, true);
    plane.points /= plane.model[9];
    plane.model[9] = 1.0;
    on_plane += best(plane, SharedFocal::SolveMinimal(plane.points, set, models)) < 1e-6 ? 1 : 0;
  }
  CAPTURE(found, on_plane);
  CHECK(found >= 0.98 * kTrials);
  CHECK(on_plane >= 0.95 * kTrials);
}

TEST_CASE("fits and refinements without noise end at the true model") {
  CheckFits<SharedFocal>(kBoth);
  CheckFits<OneFocal>(kSecond);
}

TEST_CASE("a narrow prior holds the focal length, a wide one lets the points decide") {
  Rng rng(5);
  const UnknownFocalScene scene = MakeUnknownFocalScene(kBoth, 200, rng, 1e-3);
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(200);
  RefineOptions options;
  options.loss = {LossKind::kTrivial};
  FocalParameters free = scene.model, held = scene.model;
  CHECK(RefineFocal(kBoth, scene.points, weights, options, {2.0 * scene.model[9], 1e3}, &free).status == Status::kOk);
  CHECK(free[9] == Approx(scene.model[9]).epsilon(0.05));
  CHECK(RefineFocal(kBoth, scene.points, weights, options, {1.2 * scene.model[9], 1e-5}, &held).status == Status::kOk);
  CHECK(held[9] == Approx(1.2 * scene.model[9]).epsilon(0.01));
}

TEST_CASE("the variance of residuals is their noise's, whatever the loss") {
  Rng rng(6);
  Eigen::VectorXd distances(20000);
  for (double& distance : distances) distance = std::abs(0.5 * rng.Normal());
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(distances.size());
  const auto variance = [&](const RobustLoss& loss, const Eigen::VectorXd& weights) {
    return ResidualVariance(loss, distances.data(), weights.data(), static_cast<int>(distances.size()), 6);
  };
  CHECK(variance({LossKind::kTrivial}, ones) == Approx(0.25).epsilon(0.03));
  // A weight of a half is that of half the information: the cost over it says as much.
  CHECK(variance({LossKind::kTrivial}, 0.5 * ones) == Approx(0.125).epsilon(0.03));
  // Huber's: the sandwich of normal residuals, E ψ² / E ψ', by the closed form for c = σ.
  CHECK(variance({LossKind::kHuber, 0.5}, ones) == Approx(0.25 * (0.1987 + 0.3173) / 0.6827).epsilon(0.03));
  CHECK(ResidualVariance({LossKind::kTrivial}, distances.data(), ones.data(), 6, 6) == 0.0);
}

TEST_CASE("models of unknown focal length know what they cannot be fitted to") {
  Rng rng(7);
  const UnknownFocalScene scene = MakeUnknownFocalScene(kBoth, 30, rng);
  FocalParameters model = scene.model;
  const FocalParameters before = model;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(30);
  weights.head<5>().setOnes();
  CHECK_FALSE(SharedFocal::FitFrom(scene.points, weights, &model));
  CHECK_FALSE(SharedFocal::Fit(scene.points, weights, &model));
  PointMatrix broken = scene.points;
  broken(3, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(SharedFocal::FitFrom(broken, Eigen::VectorXd::Ones(30), &model));
  CHECK_FALSE(SharedFocal::Refine(scene.points, -Eigen::VectorXd::Ones(30), {LossKind::kTrivial}, &model));
  CHECK_FALSE(SharedFocal::Refine(scene.points, Eigen::VectorXd::Ones(30), {LossKind::kTruncated, 0.0}, &model));
  CHECK(model == before);
  CHECK_FALSE(SharedFocal::Determined(scene.points.topRows(5)));
  CHECK_FALSE(SharedFocal::Determined(scene.points.row(0).replicate(9, 1)));
  PointMatrix line = scene.points;
  line.col(1) = line.col(0);
  CHECK_FALSE(SharedFocal::Determined(line));
}

}  // namespace diffsac
