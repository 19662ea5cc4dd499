#pragma once

#include <optional>
#include <vector>

#include "diffsac/geometry/degeneracy.h"
#include "diffsac/geometry/points.h"
#include "lab/colmap/two_view_geometries.h"

namespace diffsac {

/// What an estimate says of a pair, in our pixels.
struct FoundGeometry {
  const PointMatrix& points;          ///< N × 4, of cameras without distortion.
  std::vector<std::int32_t> inliers;  ///< Their rows.
  Degeneracy degeneracy = Degeneracy::kNotTested;
  std::optional<RigidMotion> motion = {};
  std::optional<Eigen::Matrix3d> homography = {};
  Eigen::Matrix3d fundamental = Eigen::Matrix3d::Zero();  ///< Unless there is a homography.
  std::optional<Eigen::Matrix3d> essential = {};          ///< Of the cameras that the database has.
};

/// The row of `two_view_geometries` without the pair and its inliers. E makes a calibrated pair, F an uncalibrated one,
/// H a planar or panoramic one; what leaves the translation open is panoramic, planar or panoramic, or a watermark,
/// with H.
ColmapGeometry GeometryOf(const FoundGeometry& found);

}  // namespace diffsac
