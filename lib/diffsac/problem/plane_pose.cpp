#include "diffsac/problem/plane_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "diffsac/geometry/covariance.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/homography_decomposition.h"
#include "diffsac/geometry/model.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/robust_map.h"

namespace diffsac {
namespace {

/// Wrong inliers may lie anywhere, beyond the plane's horizon too.
constexpr double kLeastVisible = 0.8;

/// At most two, those that most of the inliers see. Of a camera that all but turned the plane may be anywhere: then
/// one.
std::vector<RigidMotion> VisibleMotions(const Eigen::Matrix3d& h, const PointMatrix& rows, const CameraPair& cameras) {
  const PlaneMotions motions = DecomposeHomography(h, cameras.K1, cameras.K2);
  if (motions.count == 1) return {{motions.motions[0].rotation, Eigen::Vector3d::Zero()}};
  const Eigen::Matrix3d to_rays = cameras.K1.inverse();
  std::vector<std::pair<Eigen::Index, RigidMotion>> visible;
  for (int i = 0; i < motions.count; ++i) {
    const PlaneMotion& motion = motions.motions[i];
    const Eigen::RowVector3d plane = motion.normal.transpose() * to_rays;
    const Eigen::Index count = ((rows.leftCols(2) * plane.head<2>().transpose()).array() + plane[2] > 0.0).count();
    visible.emplace_back(-count, RigidMotion{motion.rotation, motion.translation.normalized()});
  }
  std::stable_sort(visible.begin(), visible.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<RigidMotion> kept;
  for (std::size_t i = 0; i < std::min<std::size_t>(2, visible.size()); ++i)
    if (i == 0 || -static_cast<double>(visible[i].first) >= kLeastVisible * static_cast<double>(rows.rows()))
      kept.push_back(visible[i].second);
  return kept;
}

Matrix3Parameters EssentialOf(const RigidMotion& motion) {
  return AsParameters(EssentialFromPose({motion.rotation, motion.translation}));
}

/// log of how likely the matches are by their distances from epipolar lines, over that of wrong matches alone.
double LogLikelihood(const Eigen::ArrayXd& distances, double sigma, double extent, double share) {
  const double density = std::sqrt(2.0 / std::numbers::pi) / sigma;
  const double odds = share / (1.0 - share) * extent * density;
  return (1.0 + odds * (-0.5 * (distances / sigma).square()).exp()).log().sum();
}

}  // namespace

std::optional<PlanePoses> PosesOfPlane(const Eigen::Matrix3d& homography, const PlaneViews& views) {
  if (!homography.allFinite()) return std::nullopt;
  std::vector<RigidMotion> motions = VisibleMotions(homography, RowsOf(views.points, views.inliers), views.cameras);
  if (motions.empty()) return std::nullopt;
  if (motions.size() == 1) return PlanePoses{motions[0]};
  PlanePoses poses{motions[0], motions[1], LogOdds(motions[0], motions[1], views)};
  if (poses.log_odds < 0.0) {
    std::swap(poses.pose, *poses.other);
    poses.log_odds = -poses.log_odds;
  }
  return poses;
}

double LogOdds(const RigidMotion& motion, const RigidMotion& other, const PlaneViews& views) {
  // Residuals of photographs are neither Gaussian nor independent (docs/two_view.md).
  constexpr double kTemper = 0.068;
  constexpr double kLeastShare = 0.01, kLeastSigma = 0.05;
  const PointMatrix points = NormalizedCoordinates(views.points, views.cameras.K1, views.cameras.K2);
  const double threshold = views.threshold / views.cameras.MeanFocal();
  const auto refined = [&](const Matrix3Parameters& start) {
    Matrix3Parameters e = start;
    Essential::Refine(points, Eigen::VectorXd::Ones(points.rows()), {LossKind::kTruncated, threshold}, &e);
    return e;
  };
  const Matrix3Parameters start = EssentialOf(other), e1 = refined(EssentialOf(motion));
  Matrix3Parameters e2 = refined(start);
  // A motion that is no minimum of its own ends at the first one: it is judged where it was.
  if (std::abs(e2.dot(e1)) > std::abs(e2.dot(start.normalized()))) e2 = start;
  const Eigen::VectorXd first = RowResiduals<Essential>(points, e1), second = RowResiduals<Essential>(points, e2);
  constexpr int kMotion = 5;
  const double found =
      std::min(NoiseOfInliers(first, 1, kMotion, threshold), NoiseOfInliers(second, 1, kMotion, threshold));
  const double sigma = std::isfinite(found) ? std::max(found, kLeastSigma * threshold) : threshold;
  const auto within = static_cast<double>((first.array().min(second.array()) <= threshold).count());
  const double share = std::clamp(within / static_cast<double>(points.rows()), kLeastShare, 1.0 - kLeastShare);
  const double extent = Extent(points);
  return kTemper * (LogLikelihood(first, sigma, extent, share) - LogLikelihood(second, sigma, extent, share));
}

std::optional<PlanePoses> PosesOfPlane(const PlaneViews& views) {
  const PointMatrix rows = RowsOf(views.points, views.inliers);
  if (rows.rows() < Homography::kMinimalSize) return std::nullopt;
  constexpr double kLeastLength = 1e-6;  // Of the points' extent: what is exact has no scale.
  const double greatest = Extent(rows);
  Eigen::Matrix3d homography;
  if (!(greatest > 0.0) || !FitRobustly(rows, kLeastLength * greatest, greatest, FitHomography, &homography))
    return std::nullopt;
  return PosesOfPlane(homography, views);
}

}  // namespace diffsac
