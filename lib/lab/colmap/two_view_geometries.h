#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "diffsac/geometry/degeneracy.h"
#include "diffsac/geometry/points.h"
#include "diffsac/geometry/rigid_motion.h"
#include "lab/colmap/database.h"

namespace diffsac {

/// COLMAP's name for what a pair was found to be.
enum class ColmapConfiguration {
  kDegenerate = 1,
  kCalibrated = 2,
  kUncalibrated = 3,
  kPanoramic = 5,
  kPlanarOrPanoramic = 6,
  kWatermark = 7
};

/// COLMAP's least number of inliers of a verified pair; its mapper takes no others.
inline constexpr int kColmapMinInliers = 15;

/// A row of `two_view_geometries`. Matrices act on homogeneous column vectors; unknown ones are zero, as COLMAP leaves
/// them.
struct ColmapGeometry {
  ColmapPair pair;
  ColmapConfiguration configuration = ColmapConfiguration::kDegenerate;
  MatchIndices inliers = MatchIndices(0, 2);  ///< Keypoints of image 1 and 2; none unless the pair is verified.
  Eigen::Matrix3d fundamental = Eigen::Matrix3d::Zero();  ///< x2ᵀ F x1 = 0 in COLMAP's pixels.
  Eigen::Matrix3d essential = Eigen::Matrix3d::Zero();    ///< The same in coordinates K⁻¹ x.
  Eigen::Matrix3d homography = Eigen::Matrix3d::Zero();   ///< x2 ~ H x1 in COLMAP's pixels.
  std::optional<RigidMotion> motion;                      ///< Of camera 2 seen from camera 1.
};

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

/// From our pixels, whose first centre is (0, 0), to COLMAP's, where it is (0.5, 0.5).
Eigen::Matrix3d FundamentalInColmapPixels(const Eigen::Matrix3d& fundamental);
Eigen::Matrix3d HomographyInColmapPixels(const Eigen::Matrix3d& homography);

/// The geometry with its images exchanged.
ColmapGeometry Exchanged(const ColmapGeometry& geometry);

/// Writes all of them, or none. Pairs of which `pair.image1` is the larger id are exchanged first. A pair that fails,
/// or has fewer inliers than kColmapMinInliers, is written as COLMAP does: degenerate, without inliers and models.
/// Throws Error, starting with the database's path: pairs that have a geometry already (unless `overwrite`), inliers
/// that are no keypoints or, where the database has matches of the pair, none of these; a database that cannot be
/// written.
void WriteGeometries(const ColmapDatabase& database, const std::vector<ColmapGeometry>& geometries, bool overwrite);

}  // namespace diffsac
