#include "diffsac/estimate/focal_conflict.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "diffsac/core/random.h"
#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

constexpr double kFocal = 450.0;

Eigen::Matrix3d Camera(double focal) {
  Eigen::Matrix3d K = Eigen::Vector3d(focal, focal, 1.0).asDiagonal();
  K.topRightCorner<2, 1>() << 399.5, 299.5;
  return K;
}

/// 200 right matches and 50 wrong ones of images of 800 × 600, with an E that suits calibrations `factor` times as long
/// as they are, and `unit` pixels for each.
struct Views {
  Problem problem;
  Estimate estimate;

  explicit Views(double factor, double noise_px = 0.5, double unit = 1.0, double second = kFocal, bool flat = false) {
    Rng rng(3);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.19, Eigen::Vector3d(0.2, 1.0, 0.1).normalized()).toRotationMatrix();
    const Eigen::Vector3d t(-1.2, 0.25, 0.5);
    problem.points.resize(250, 4);
    for (int i = 0; i < 250; ++i) {
      const Eigen::Vector2d x(rng.Uniform(0.0, 800.0), rng.Uniform(0.0, 600.0));
      const double depth = flat ? 6.0 : rng.Uniform(4.0, 9.0);
      const Eigen::Vector3d point = depth * (Camera(kFocal).inverse() * x.homogeneous());
      const Eigen::Vector2d y = (Camera(second) * (R * point + t)).hnormalized();
      const Eigen::Vector2d wrong(rng.Uniform(0.0, 800.0), rng.Uniform(0.0, 600.0));
      problem.points.row(i) << x.transpose(), (i < 200 ? y : wrong).transpose();
      for (int c = 0; c < 4; ++c) problem.points(i, c) += noise_px * rng.Normal();
    }
    problem.points *= unit;
    problem.size1 = problem.size2 = {static_cast<int>(800 * unit), static_cast<int>(600 * unit)};
    problem.task = Task::kEssential;
    problem.inlier_threshold = 4.0 * noise_px * unit;
    const auto said = [&](double focal) {
      const Eigen::Matrix3d pixels = Eigen::Vector3d(unit, unit, 1.0).asDiagonal();
      return Eigen::Matrix3d(pixels * Camera(factor * focal));
    };
    problem.cameras = CameraPair{said(kFocal), said(kFocal)};
    const PointMatrix points = NormalizedCoordinates(problem.points, problem.cameras->K1, problem.cameras->K2);
    Matrix3Parameters e = AsParameters(EssentialFromPose({R, t}));
    RefineOptions options;
    options.loss = {LossKind::kTruncated, problem.inlier_threshold / problem.cameras->MeanFocal()};
    RefineOptions far = options;
    far.loss.kind = LossKind::kHuber;
    const Eigen::VectorXd right = Eigen::VectorXd::Ones(200);
    RefineEssential(points.topRows(200), right, far, &e);
    RefineEssential(points.topRows(200), right, options, &e);
    estimate.status = Status::kOk;
    estimate.model = e;
    estimate.inlier_threshold = problem.inlier_threshold;
    estimate.inliers.assign(250, 1);
  }

  std::optional<FocalConflict> Conflict() const { return FindFocalConflict(NormalizedProblem(problem), estimate); }
};

/// As an estimate of one unknown length, of the prior's or `estimated`, says.
Views OfPrior(double prior, double log_sigma, double estimated) {
  Views views(estimated / kFocal);
  views.problem.task = Task::kSharedFocal;
  views.problem.cameras.reset();
  views.problem.camera_prior1.focal = views.problem.camera_prior2.focal = FocalPrior{prior, log_sigma};
  FocalEstimate focal;
  focal.focal_px = {estimated, estimated};
  focal.low_px = focal.focal_px;
  focal.high_px = focal.focal_px;
  focal.observable = {true, true};
  focal.prior_focal_px = {prior, prior};
  focal.prior_log_sigma = {log_sigma, log_sigma};
  views.estimate.focal = focal;
  views.estimate.model =
      AsFocalParameters(Matrix3Parameters(views.estimate.model), estimated / prior, estimated / prior);
  return views;
}

}  // namespace

TEST_CASE("a calibration of another focal length contradicts matches") {
  for (const double factor : {0.4, 0.6, 1.5, 2.0}) {
    CAPTURE(factor);
    const auto conflict = Views(factor).Conflict();
    REQUIRE(conflict);
    CHECK(conflict->said_px[0] == Approx(factor * kFocal));
    CHECK(conflict->found_px[1] == Approx(kFocal).epsilon(0.1));
    CHECK(conflict->low_px[0] < conflict->found_px[0]);
    CHECK(conflict->found_px[0] < conflict->high_px[0]);
  }
}

TEST_CASE("a right calibration does not contradict noisy matches") {
  for (const double noise_px : {0.1, 0.5, 2.0}) CHECK_FALSE(Views(1.0, noise_px).Conflict());
  CHECK_FALSE(Views(1.03).Conflict());
}

TEST_CASE("a conflict goes with the unit of pixels") {
  const auto conflict = Views(1.5).Conflict(), larger = Views(1.5, 0.5, 10.0).Conflict();
  REQUIRE(conflict);
  REQUIRE(larger);
  CHECK(larger->said_px[0] == Approx(10.0 * conflict->said_px[0]));
  CHECK(larger->found_px[0] == Approx(10.0 * conflict->found_px[0]).epsilon(0.01));
  CHECK_FALSE(Views(1.0, 0.5, 10.0).Conflict());
}

TEST_CASE("matches of one plane contradict no calibration") {
  CHECK_FALSE(Views(1.5, 0.5, 1.0, kFocal, true).Conflict());
}

TEST_CASE("a prior contradicts matches by its width") {
  for (const double prior : {225.0, 900.0, 1800.0}) {
    CAPTURE(prior);
    Views views = OfPrior(prior, 0.1, std::sqrt(prior * kFocal));
    TellFocalConflict(NormalizedProblem(views.problem), &views.estimate);
    REQUIRE(views.estimate.focal_conflict);
    CHECK(views.estimate.focal_conflict->said_px[0] == Approx(prior));
    CHECK(views.estimate.focal_conflict->found_px[0] == Approx(kFocal).epsilon(0.1));
    CHECK(views.estimate.MayBeWrong());
    CHECK_FALSE(views.estimate.focal->observable[0]);
    CHECK(views.estimate.focal->low_px[1] <= views.estimate.focal_conflict->low_px[1]);
    CHECK(views.estimate.focal->high_px[1] >= views.estimate.focal_conflict->high_px[1]);
  }
  CHECK_FALSE(OfPrior(460.0, 0.1, kFocal).Conflict());
  CHECK_FALSE(OfPrior(700.0, 0.43, kFocal).Conflict());
}

}  // namespace diffsac
