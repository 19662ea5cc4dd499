#include "diffsac/geometry/shared_focal.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/geometry/focal_posterior.h"
#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/sampson_equations.h"
#include "diffsac/geometry/six_points.h"
#include "geometry/jacobian_check.h"
#include "geometry/two_view_problems.h"

namespace diffsac {
namespace {

/// Two cameras with an unknown focal length, and matches in the coordinates that UnknownFocal says.
struct UnknownFocalScene {
  RelativePose pose;
  FocalParameters model;
  PointMatrix points;
};

enum class Motion { kAny, kForward, kPureRotation };

/// `count` points at depths 2 to 8, or on the plane z = 4 + x/2 (`planar`), with normal noise on every coordinate.
UnknownFocalScene MakeUnknownFocalScene(UnknownFocal unknown, int count, Rng& rng, double noise = 0.0,
                                        Motion motion = Motion::kAny, bool planar = false) {
  UnknownFocalScene scene;
  scene.pose = testing::RandomPose(rng, 0.4);
  if (motion == Motion::kForward) scene.pose = {Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitZ()};
  const double focal = std::exp(rng.Uniform(-0.5, 0.5));
  double first = unknown == UnknownFocal::kBoth ? focal : 1.0;
  if (unknown == UnknownFocal::kEach) first = std::exp(rng.Uniform(-0.5, 0.5));
  scene.points.resize(count, 4);
  const Eigen::Vector3d translation = motion == Motion::kPureRotation ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                                                      : Eigen::Vector3d(scene.pose.translation);
  for (int i = 0; i < count;) {
    const double x = rng.Uniform(-0.4, 0.4), y = rng.Uniform(-0.4, 0.4);
    const double depth = planar ? 4.0 / (1.0 - 0.5 * x) : rng.Uniform(2.0, 8.0);
    const Eigen::Vector3d a = depth * Eigen::Vector3d(x, y, 1.0), b = scene.pose.rotation * a + translation;
    if (b[2] < 0.5) continue;
    scene.points.row(i) << first * a.hnormalized().transpose(), focal * b.hnormalized().transpose();
    for (int j = 0; j < 4; ++j) scene.points(i, j) += noise * rng.Normal();
    ++i;
  }
  scene.model = AsFocalParameters(AsParameters(EssentialFromPose(scene.pose)), first, focal);
  return scene;
}

/// Of E, whichever sign it has, and of log f.
double FocalModelDistance(const FocalParameters& a, const FocalParameters& b) {
  return testing::ModelDistance(a.head<9>(), b.head<9>()) + std::abs(std::log(a[9] / b[9])) +
         std::abs(std::log(a[10] / b[10]));
}

constexpr UnknownFocal kBoth = UnknownFocal::kBoth, kSecond = UnknownFocal::kSecond, kEach = UnknownFocal::kEach;

FocalPriors Same(const FocalPrior& prior) { return {prior, prior}; }

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
template <UnknownFocal kUnknown>
FocalParameters Disturbed(const FocalParameters& model, Rng& rng) {
  typename FocalManifold<kUnknown, false>::Step step;
  for (double& value : step) value = 0.03 * rng.Normal();
  return FocalManifold<kUnknown, false>::From(model).Retract(step).Model();
}

template <UnknownFocal kUnknown>
void CheckFits() {
  using Model = FocalModel<kUnknown>;
  Rng rng(4);
  for (int trial = 0; trial < 20; ++trial) {
    CAPTURE(trial);
    const UnknownFocalScene scene = MakeUnknownFocalScene(kUnknown, 60, rng);
    FocalParameters model;
    REQUIRE(Model::Fit(scene.points, Eigen::VectorXd::Ones(60), &model));
    CHECK(FocalModelDistance(model, scene.model) < 1e-3);
    // The prior weighs as the residuals do at the start: nothing at the true model.
    model = Disturbed<kUnknown>(scene.model, rng);
    for (int round = 0; round < 3; ++round) REQUIRE(Model::FitFrom(scene.points, Eigen::VectorXd::Ones(60), &model));
    CHECK(FocalModelDistance(model, scene.model) < 1e-3);
    model = Disturbed<kUnknown>(scene.model, rng);
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
    CheckTangent<FocalManifold<kEach, false>>(scene.model, scene.points.data());
    CheckTangent<FocalManifold<kEach, true>>(scene.model, scene.points.data());
  }
}

TEST_CASE("the prior's share of the normal equations is its penalty's derivative") {
  Rng rng(2);
  FocalManifold<kEach, false> state = FocalManifold<kEach, false>::From(MakeUnknownFocalScene(kEach, 1, rng).model);
  state.prior_weight = {5.0, 3.0};
  state.log_median = {-0.1, 0.2};
  Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> gradient = Eigen::Matrix<double, 7, 1>::Zero();
  state.AddPenalty(&normal, &gradient);
  const auto penalty = [&](const Eigen::VectorXd& step) {
    return Eigen::VectorXd::Constant(1, state.Retract(Eigen::Matrix<double, 7, 1>(step)).Penalty()).eval();
  };
  testing::CheckJacobian(penalty, Eigen::VectorXd::Zero(7), 2.0 * gradient.transpose());
  CHECK(normal(5, 5) == 5.0);
  CHECK(normal(6, 6) == 3.0);
  CHECK(normal.sum() == 8.0);
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
    plane.model.tail<2>().setOnes();
    on_plane += best(plane, SharedFocal::SolveMinimal(plane.points, set, models)) < 1e-6 ? 1 : 0;
  }
  CAPTURE(found, on_plane);
  CHECK(found >= 0.98 * kTrials);
  CHECK(on_plane >= 0.95 * kTrials);
}

TEST_CASE("fits and refinements without noise end at the true model") {
  CheckFits<kBoth>();
  CheckFits<kSecond>();
  CheckFits<kEach>();
}

TEST_CASE("a narrow prior holds the focal length, a wide one lets the points decide") {
  Rng rng(5);
  const UnknownFocalScene scene = MakeUnknownFocalScene(kBoth, 200, rng, 1e-3);
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(200);
  RefineOptions options;
  options.loss = {LossKind::kTrivial};
  FocalParameters free = scene.model, held = scene.model;
  CHECK(RefineFocal(kBoth, scene.points, weights, options, Same({2.0 * scene.model[9], 1e3}), &free).status ==
        Status::kOk);
  CHECK(free[9] == Approx(scene.model[9]).epsilon(0.05));
  CHECK(RefineFocal(kBoth, scene.points, weights, options, Same({1.2 * scene.model[9], 1e-5}), &held).status ==
        Status::kOk);
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

namespace {

template <UnknownFocal kUnknown>
int Solve(const PointMatrix& points, FocalParameters* out) {
  double p[6][4];
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 4; ++j) p[i][j] = points(i, j);
  return SolveSixPoints<kUnknown>(p, out);
}

template <UnknownFocal kUnknown>
void CheckRecovers() {
  Rng rng(1);
  int recovered = 0, all = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto scene = MakeUnknownFocalScene(kUnknown, 6, rng);
    FocalParameters models[MaxSixPointSolutions(kUnknown)];
    const int count = Solve<kUnknown>(scene.points, models);
    all += count;
    double best = 9.0;
    for (int k = 0; k < count; ++k) {
      best = std::min(best, FocalModelDistance(models[k], scene.model));
      const Matrix3Parameters essential = models[k].template head<9>();
      const Eigen::Matrix3d e = AsMatrix(essential);
      CHECK((2.0 * e * e.transpose() * e - (e * e.transpose()).trace() * e).norm() < 1e-7);
      for (int i = 0; i < 6; ++i) {
        const Eigen::Matrix3d f = AsMatrix(FundamentalOf(models[k]));
        const Eigen::Vector3d x1(scene.points(i, 0), scene.points(i, 1), 1.0);
        const Eigen::Vector3d x2(scene.points(i, 2), scene.points(i, 3), 1.0);
        CHECK(std::abs(x2.dot(f * x1)) < 1e-10 * std::max(1.0, f.norm()));
      }
    }
    recovered += best < 1e-6 ? 1 : 0;
  }
  CAPTURE(all, recovered);
  CHECK(recovered >= 0.99 * kTrials);
  CHECK(all > 2 * kTrials);
}

}  // namespace

TEST_CASE("the six-point solvers recover E and f, and all they give are solutions") {
  CheckRecovers<UnknownFocal::kBoth>();
  CheckRecovers<UnknownFocal::kSecond>();
}

TEST_CASE("the six-point solver of a shared focal length has PoseLib's solutions") {
  // PoseLib 2.0.5, shared_focal_relpose_6pt of these points: each a focal length, R and t.
  PointMatrix points(6, 4);
  points << -0.38, -0.02, -0.57, -0.25, -0.22, -0.28, -0.37, -0.48, 0.23, 0.18, -0.04, 0.06, 0.05, -0.26, -0.13, -0.39,
      -0.41, -0.11, -0.57, -0.35, -0.05, 0.01, -0.26, -0.14;
  struct Solution {
    double focal;
    double rotation[9], translation[3];
  };
  const Solution golden[] = {
      {0.6075603732538384,
       {0.9766093899184104, -0.21143656781845607, -0.03909830319005782, 0.2135996206526559, 0.9331052725673378,
        0.28929181178193736, -0.024684034926076306, -0.2908764825423083, 0.9564421416497615},
       {-0.5060059767538901, -0.859205588101347, 0.07565519720918144}},
      {2.611569225374325,
       {0.973135569341926, -0.21639146358981212, -0.07862504796198509, 0.21292511204531953, 0.9757791842609553,
        -0.05017848367091864, 0.08757888068509188, 0.03208922012893966, 0.9956406086582964},
       {-0.1402465005604308, -0.18852593094158507, 0.9720025166856112}}};
  FocalParameters models[15];
  const int count = Solve<UnknownFocal::kBoth>(points, models);
  for (const Solution& solution : golden) {
    RelativePose pose;
    pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(solution.rotation);
    pose.translation = Eigen::Map<const Eigen::Vector3d>(solution.translation);
    const FocalParameters model = AsFocalParameters(kBoth, AsParameters(EssentialFromPose(pose)), solution.focal);
    double best = 9.0;
    for (int k = 0; k < count; ++k) best = std::min(best, FocalModelDistance(models[k], model));
    CHECK(best < 1e-7);
  }
}

TEST_CASE("F says two focal lengths, but not where the axes meet, and seven points give the true model") {
  Rng rng(8);
  int found = 0;
  const int set[] = {0, 1, 2, 3, 4, 5, 6};
  constexpr int kTrials = 300;
  for (int trial = 0; trial < kTrials; ++trial) {
    const UnknownFocalScene scene = MakeUnknownFocalScene(kEach, 7, rng);
    double focal1 = 0.0, focal2 = 0.0;
    REQUIRE(FocalsOfFundamental(FundamentalOf(scene.model), &focal1, &focal2));
    CHECK(focal1 == Approx(scene.model[9]).epsilon(1e-6));
    CHECK(focal2 == Approx(scene.model[10]).epsilon(1e-6));
    FocalParameters models[TwoFocals::kMaxSolutions];
    const int count = TwoFocals::SolveMinimal(scene.points, set, models);
    double least = 9.0;
    for (int k = 0; k < count; ++k) least = std::min(least, FocalModelDistance(models[k], scene.model));
    found += least < 1e-5 ? 1 : 0;
  }
  CAPTURE(found);
  CHECK(found >= 0.95 * kTrials);
  // A camera beside the other one, both looking at one point.
  RelativePose fixating;
  const double angle = 0.3;
  fixating.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
  fixating.translation = Eigen::Vector3d(0.0, 0.0, 1.0) - fixating.rotation * Eigen::Vector3d(0.0, 0.0, 1.0);
  double focal1 = 0.0, focal2 = 0.0;
  const Matrix3Parameters e = AsParameters(EssentialFromPose(fixating));
  CHECK_FALSE(FocalsOfFundamental(WithFocals(e, 1.2, 0.8), &focal1, &focal2));
}

TEST_CASE("sets that determine nothing have no six-point solution") {
  Rng rng(2);
  FocalParameters models[15];
  const auto scene = MakeUnknownFocalScene(UnknownFocal::kBoth, 6, rng);
  PointMatrix twice = scene.points;
  twice.row(5) = twice.row(0);
  CHECK(Solve<UnknownFocal::kBoth>(twice, models) == 0);
  PointMatrix equal = scene.points.row(0).replicate(6, 1);
  CHECK(Solve<UnknownFocal::kBoth>(equal, models) == 0);
  PointMatrix broken = scene.points;
  broken(3, 2) = std::numeric_limits<double>::quiet_NaN();
  CHECK(Solve<UnknownFocal::kBoth>(broken, models) == 0);
  CHECK(Solve<UnknownFocal::kSecond>(broken, models) == 0);
}

namespace {

constexpr double kNoise = 1e-3;
const RobustLoss kLoss{LossKind::kMarginalised, 4e-3, 1e-3};

bool Marginalise(UnknownFocal unknown, const UnknownFocalScene& scene, const FocalPriors& priors,
                 FocalParameters* model, FocalPosteriors* out) {
  return MarginaliseFocal(unknown, scene.points, Eigen::VectorXd::Ones(scene.points.rows()), kLoss, priors, model, out);
}

template <class Draw>
void CheckCalibrated(UnknownFocal unknown, double log_sigma, const Draw& draw) {
  // A grid of two dimensions takes longer.
  const int trials = unknown == kEach ? 100 : 200;
  Rng rng(1);
  int covered = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const UnknownFocalScene scene = draw(rng);
    // The truth is a draw from the prior.
    const double first = std::exp(log_sigma * rng.Normal()),
                 second = unknown == kEach ? std::exp(log_sigma * rng.Normal()) : first;
    const FocalPriors priors = {{{scene.model[9] * first, log_sigma}, {scene.model[10] * second, log_sigma}}};
    FocalParameters model = scene.model;
    FocalPosteriors posterior;
    REQUIRE(Marginalise(unknown, scene, priors, &model, &posterior));
    const int image = unknown == kEach ? trial % 2 : 1;
    const double truth = scene.model[9 + image];
    covered += posterior[image].low <= truth && truth <= posterior[image].high ? 1 : 0;
  }
  CAPTURE(covered);
  // At least .68, within three standard deviations: made wider for what photographs have beside noise.
  CHECK(covered >= (0.68 - 3.0 * std::sqrt(0.68 * 0.32 / trials)) * trials);
}

}  // namespace

TEST_CASE(
    "the interval of the focal length holds the true one in 68 of 100 problems at least where four matches share an "
    "error") {
  for (const UnknownFocal unknown : {kBoth, kSecond, kEach}) {
    CAPTURE(static_cast<int>(unknown));
    const auto shared = [](UnknownFocalScene scene) {
      scene.points = scene.points.replicate(4, 1).eval();
      return scene;
    };
    const auto any = [&](Rng& rng) { return shared(MakeUnknownFocalScene(unknown, 60, rng, kNoise)); };
    const auto forward = [&](Rng& rng) {
      return shared(MakeUnknownFocalScene(unknown, 60, rng, kNoise, Motion::kForward));
    };
    CheckCalibrated(unknown, 0.3, any);
    CheckCalibrated(unknown, 0.1, any);
    CheckCalibrated(unknown, 0.2, forward);
  }
}

TEST_CASE("an interval is no surer than its floor") {
  Eigen::Matrix2d information;
  information << 900.0, -850.0, -850.0, 1000.0;
  const Eigen::Matrix2d wide = IntervalInformation<Eigen::Matrix2d>(information);
  for (int k = 0; k < 2; ++k) CHECK(wide(k, k) < information(k, k));
  const Eigen::Matrix2d sure = IntervalInformation<Eigen::Matrix2d>(1e9 * Eigen::Matrix2d::Identity());
  CHECK(1.0 / std::sqrt(sure(0, 0)) == Approx(kIntervalFloor).epsilon(1e-3));
  const Eigen::Matrix2d unsure = IntervalInformation<Eigen::Matrix2d>(1e-3 * Eigen::Matrix2d::Identity());
  CHECK(1e-3 / unsure(0, 0) == Approx(kIntervalFactor * kIntervalFactor).epsilon(1e-3));
}

TEST_CASE("matches near a plane widen the interval") {
  const FocalPriors priors = {{{1.0, 0.4}, {1.0, 0.4}}};
  for (const UnknownFocal unknown : {kBoth, kEach}) {
    double width = 0.0;
    for (const int on_plane : {0, 50, 80}) {
      Rng rng(4);
      UnknownFocalScene scene = MakeUnknownFocalScene(unknown, 100, rng, 0.1 * kNoise);
      if (on_plane > 0) {
        Rng same(4);
        const UnknownFocalScene plane = MakeUnknownFocalScene(unknown, 100, same, 0.1 * kNoise, Motion::kAny, true);
        const Matrix3Parameters f = FundamentalOf(scene.model);
        REQUIRE(SampsonError(f, plane.points.row(0).data()) < kNoise);  // Of the same motion.
        scene.points.topRows(on_plane) = plane.points.topRows(on_plane);
      }
      FocalParameters model = scene.model;
      FocalPosteriors out;
      REQUIRE(Marginalise(unknown, scene, priors, &model, &out));
      const double now = out[1].high / out[1].low;
      CHECK(now > width);
      CHECK(out[1].low <= out[1].focal);
      CHECK(out[1].focal <= out[1].high);
      width = now;
    }
  }
}

TEST_CASE("lengths that are held have had no posterior") {
  Rng rng(3);
  for (int trial = 0; trial < 20; ++trial)
    for (const UnknownFocal unknown : {kBoth, kSecond, kEach}) {
      const UnknownFocalScene scene = MakeUnknownFocalScene(unknown, 100, rng, kNoise);
      constexpr double kHeld = 2e-3;
      const FocalPriors priors = {{{scene.model[9], kHeld}, {scene.model[10], kHeld}}};
      FocalParameters model = scene.model;
      FocalPosteriors posterior;
      REQUIRE(Marginalise(unknown, scene, priors, &model, &posterior));
      CHECK(posterior[1].high / posterior[1].low == Approx(std::exp(2.0 * kHeld)).epsilon(kHeld));
    }
}

TEST_CASE("where the motion shows the focal length the matches decide, else the prior does") {
  Rng rng(2);
  for (int trial = 0; trial < 10; ++trial) {
    FocalPosteriors posteriors;
    const FocalPosterior& posterior = posteriors[1];
    UnknownFocalScene scene = MakeUnknownFocalScene(UnknownFocal::kBoth, 400, rng, 1e-4);
    // A sideways look turned about two axes shows it.
    scene.pose.translation = Eigen::Vector3d::UnitX();
    FocalParameters model = scene.model;
    const FocalPrior off{1.4 * scene.model[9], 0.5};
    REQUIRE(Marginalise(UnknownFocal::kBoth, scene, Same(off), &model, &posteriors));
    if (posterior.observable) CHECK(posterior.focal == Approx(scene.model[9]).epsilon(0.25));
    CHECK(posterior.low <= posterior.high);
    CHECK(model[9] == Approx(posterior.focal));

    scene = MakeUnknownFocalScene(UnknownFocal::kBoth, 400, rng, 1e-4, Motion::kForward);
    model = scene.model;
    REQUIRE(Marginalise(UnknownFocal::kBoth, scene, Same(off), &model, &posteriors));
    CHECK_FALSE(posterior.observable);
    CHECK(posterior.focal == Approx(off.focal).epsilon(0.1));
    CHECK(posterior.prior.focal == off.focal);
  }
}

TEST_CASE("a posterior needs points and a prior") {
  Rng rng(3);
  const UnknownFocalScene scene = MakeUnknownFocalScene(UnknownFocal::kBoth, 30, rng, kNoise);
  FocalParameters model = scene.model;
  FocalPosteriors posterior;
  UnknownFocalScene few = scene;
  few.points.conservativeResize(6, 4);
  CHECK_FALSE(Marginalise(UnknownFocal::kBoth, few, Same({1.0, 0.3}), &model, &posterior));
  CHECK_FALSE(Marginalise(UnknownFocal::kBoth, scene, Same({1.0, 0.0}), &model, &posterior));
  CHECK_FALSE(Marginalise(UnknownFocal::kBoth, scene, Same({0.0, 0.3}), &model, &posterior));
  CHECK(model == scene.model);
  FocalParameters broken = scene.model;
  broken[2] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(Marginalise(UnknownFocal::kBoth, scene, Same({1.0, 0.3}), &broken, &posterior));
}

}  // namespace diffsac
