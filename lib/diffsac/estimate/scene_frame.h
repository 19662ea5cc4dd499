#pragma once

#include <Eigen/Core>

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/geometry/rows_view.h"

namespace diffsac {

/// The origin and unit in which poses and motions are estimated where the scene's own would cost digits: points that
/// are farther from the origin than 16 times their extent (map coordinates), or of an extent that is not 1/4096 to
/// 4096. Others stay as they are, bit for bit.
struct SceneFrame {
  using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< In the scene.
  double unit = 1.0;                                 ///< A power of two.

  /// By the middle half of the points.
  explicit SceneFrame(const Points3DView& points);
  Points Apply(const Points3DView& points) const;
  /// The poses of an estimate by points in this frame, and the covariance, as those of the scene.
  void Restore(Estimate* estimate) const;
};

/// The motions [s R | t] of an estimate from points in one frame to points in another, and the covariance, as those
/// between the points themselves.
void RestoreMotions(const SceneFrame& from, const SceneFrame& to, Estimate* estimate);

}  // namespace diffsac
