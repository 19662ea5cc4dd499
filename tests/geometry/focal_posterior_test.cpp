#include "diffsac/geometry/focal_posterior.h"

#include <catch2/catch.hpp>
#include <limits>

#include "geometry/unknown_focal_scene.h"

namespace diffsac {
namespace {

using testing::MakeUnknownFocalScene;
using testing::Motion;
using testing::UnknownFocalScene;

constexpr double kNoise = 1e-3;
const RobustLoss kLoss{LossKind::kMarginalised, 4e-3, 1e-3};

bool Marginalise(UnknownFocal unknown, const UnknownFocalScene& scene, const FocalPrior& prior, FocalParameters* model,
                 FocalPosterior* out) {
  return MarginaliseFocal(unknown, scene.points, Eigen::VectorXd::Ones(scene.points.rows()), kLoss, prior, model, out);
}

template <class Draw>
void CheckCalibrated(UnknownFocal unknown, double log_sigma, const Draw& draw) {
  constexpr int kTrials = 300;
  Rng rng(1);
  int covered = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const UnknownFocalScene scene = draw(rng);
    // The truth is a draw from the prior.
    const FocalPrior prior{scene.model[9] * std::exp(log_sigma * rng.Normal()), log_sigma};
    FocalParameters model = scene.model;
    FocalPosterior posterior;
    REQUIRE(Marginalise(unknown, scene, prior, &model, &posterior));
    covered += posterior.low <= scene.model[9] && scene.model[9] <= posterior.high ? 1 : 0;
  }
  CAPTURE(covered);
  // .68 of 300 within three standard deviations.
  CHECK(covered >= 0.60 * kTrials);
  CHECK(covered <= 0.765 * kTrials);
}

}  // namespace

TEST_CASE(
    "the interval of the focal length holds the true one in 68 of 100 problems where four matches share an error") {
  for (const UnknownFocal unknown : {UnknownFocal::kBoth, UnknownFocal::kSecond}) {
    const auto shared = [](UnknownFocalScene scene) {
      scene.points = scene.points.replicate(4, 1).eval();
      return scene;
    };
    const auto any = [&](Rng& rng) { return shared(MakeUnknownFocalScene(unknown, 250, rng, kNoise)); };
    const auto forward = [&](Rng& rng) {
      return shared(MakeUnknownFocalScene(unknown, 250, rng, kNoise, Motion::kForward));
    };
    CheckCalibrated(unknown, 0.3, any);
    CheckCalibrated(unknown, 0.1, any);
    CheckCalibrated(unknown, 0.2, forward);
  }
}

TEST_CASE("where the motion shows the focal length the matches decide, else the prior does") {
  Rng rng(2);
  for (int trial = 0; trial < 10; ++trial) {
    FocalPosterior posterior;
    UnknownFocalScene scene = MakeUnknownFocalScene(UnknownFocal::kBoth, 400, rng, 1e-4);
    // A sideways look turned about two axes shows it.
    scene.pose.translation = Eigen::Vector3d::UnitX();
    FocalParameters model = scene.model;
    const FocalPrior off{1.4 * scene.model[9], 0.5};
    REQUIRE(Marginalise(UnknownFocal::kBoth, scene, off, &model, &posterior));
    if (posterior.observable) CHECK(posterior.focal == Approx(scene.model[9]).epsilon(0.25));
    CHECK(posterior.low <= posterior.high);
    CHECK(model[9] == Approx(posterior.focal));

    scene = MakeUnknownFocalScene(UnknownFocal::kBoth, 400, rng, 1e-4, Motion::kForward);
    model = scene.model;
    REQUIRE(Marginalise(UnknownFocal::kBoth, scene, off, &model, &posterior));
    CHECK_FALSE(posterior.observable);
    CHECK(posterior.focal == Approx(off.focal).epsilon(0.1));
    CHECK(posterior.prior.focal == off.focal);
  }
}

TEST_CASE("a posterior needs points and a prior") {
  Rng rng(3);
  const UnknownFocalScene scene = MakeUnknownFocalScene(UnknownFocal::kBoth, 30, rng, kNoise);
  FocalParameters model = scene.model;
  FocalPosterior posterior;
  UnknownFocalScene few = scene;
  few.points.conservativeResize(6, 4);
  CHECK_FALSE(Marginalise(UnknownFocal::kBoth, few, {1.0, 0.3}, &model, &posterior));
  CHECK_FALSE(Marginalise(UnknownFocal::kBoth, scene, {1.0, 0.0}, &model, &posterior));
  CHECK_FALSE(Marginalise(UnknownFocal::kBoth, scene, {0.0, 0.3}, &model, &posterior));
  CHECK(model == scene.model);
  FocalParameters broken = scene.model;
  broken[2] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(Marginalise(UnknownFocal::kBoth, scene, {1.0, 0.3}, &broken, &posterior));
}

}  // namespace diffsac
