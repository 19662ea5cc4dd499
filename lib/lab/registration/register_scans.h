#pragma once

#include "lab/registration/matched_motion.h"
#include "lab/registration/scan.h"

namespace diffsac {

/// How the first scan moves onto the second: by the matches, between points about the scans' middles (Scan::middle),
/// and by the clouds. SpreadOf with the first one's middle has the covariance of `motion`.
struct Registration : MatchedMotion {
  /// Between the files' frames: y = R x + t, after point-to-plane ICP where that brings no fewer points together.
  RigidMotion motion;
  /// The share of thinned points of the first, and of the second, within options.max_residual of the other.
  double overlap1 = 0.0, overlap2 = 0.0;
  double overlap_before = 0.0;  ///< The first's before ICP.
  double rmse = 0.0;            ///< Of the first's.
  /// How firmly the surfaces that overlap hold each other, from 0 to 1: by how much the distances between them change
  /// in the direction in which they change least, over the motion (of a turn at their root mean square radius). Gelfand
  /// et al., "Geometrically stable sampling for the ICP algorithm", 3DIM 2003.
  double hold = 0.0;
  /// Below: planes, spheres and pipes slide on themselves.
  static constexpr double kLeastHold = 0.1;
  bool slides() const { return hold < kLeastHold; }
};

/// Mutual matches of the descriptors, drawn by their ratios; then ICP of the thinned clouds. options.max_residual is of
/// both and must be given.
Registration RegisterScans(const Scan& first, const Scan& second, const RegistrationOptions& options);

/// The covariance of a registration's motion as g2o's EDGE_SE3:QUAT has it, inverted: 6 × 6 in the order of the
/// translation and the vector part of the quaternion, of what is added in the first scan's frame. Absent where the
/// estimate has no covariance.
std::optional<Eigen::Matrix<double, 6, 6>> Information(const Registration& registration,
                                                       const Eigen::Vector3d& first_middle);

}  // namespace diffsac
