#include "diffsac/problem/plane_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "diffsac/geometry/fundamental.h"
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

/// Which matches lie on the epipolar lines of a motion.
std::vector<bool> OnLines(const RigidMotion& motion, const PlaneViews& views) {
  const Eigen::Matrix3d f = FundamentalFromEssential(EssentialFromPose({motion.rotation, motion.translation}),
                                                     views.cameras.K1, views.cameras.K2);
  const Eigen::VectorXd distances = RowResiduals<Fundamental>(views.points, AsParameters(f));
  std::vector<bool> on(static_cast<std::size_t>(distances.size()));
  for (std::size_t i = 0; i < on.size(); ++i) on[i] = distances[static_cast<Eigen::Index>(i)] <= views.threshold;
  return on;
}

}  // namespace

std::optional<PlanePoses> PosesOfPlane(const Eigen::Matrix3d& homography, const PlaneViews& views) {
  if (!homography.allFinite()) return std::nullopt;
  std::vector<RigidMotion> motions = VisibleMotions(homography, RowsOf(views.points, views.inliers), views.cameras);
  if (motions.empty()) return std::nullopt;
  if (motions.size() == 1) return PlanePoses{motions[0]};
  constexpr double kChiSquared = 3.841;  // Of one degree of freedom, 1 in 20.
  const std::vector<bool> first = OnLines(motions[0], views), second = OnLines(motions[1], views);
  double more = 0.0, unlike = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    more += static_cast<double>(first[i]) - static_cast<double>(second[i]);
    unlike += first[i] != second[i];
  }
  if (more < 0.0) std::swap(motions[0], motions[1]);
  const double beyond = std::max(0.0, std::abs(more) - 1.0);
  if (unlike > 0.0 && beyond * beyond > kChiSquared * unlike) return PlanePoses{motions[0]};
  return PlanePoses{motions[0], motions[1]};
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
