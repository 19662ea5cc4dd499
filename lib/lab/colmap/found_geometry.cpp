#include "lab/colmap/found_geometry.h"

#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {
namespace {

/// Of epipolar geometry that the matches leave open: what they show is a homography, fitted to them here by the sum of
/// distances, in pixels, which a few wrong inliers do not spoil.
void SetUndetermined(const FoundGeometry& found, ColmapGeometry* geometry) {
  if (found.degeneracy == Degeneracy::kLine) return;
  geometry->configuration = found.degeneracy == Degeneracy::kPureRotation ? ColmapConfiguration::kPanoramic
                            : found.degeneracy == Degeneracy::kStatic     ? ColmapConfiguration::kWatermark
                                                                          : ColmapConfiguration::kPlanarOrPanoramic;
  constexpr int kRounds = 20;
  constexpr double kExact = 0.1;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(found.points.rows());
  for (const std::int32_t row : found.inliers) weights[row] = 1.0;
  Matrix3Parameters homography;
  bool fitted = false;
  for (int round = 0; round < kRounds && Homography::Fit(found.points, weights, &homography); ++round) {
    fitted = true;
    for (const std::int32_t row : found.inliers)
      weights[row] = 1.0 / (kExact + SymmetricTransferError(homography, found.points.row(row).data()));
  }
  if (fitted) geometry->homography = HomographyInColmapPixels(AsMatrix(homography));
}

}  // namespace

ColmapGeometry GeometryOf(const FoundGeometry& found) {
  ColmapGeometry geometry;
  geometry.motion = found.motion;
  if (IsUndetermined(found.degeneracy)) {
    SetUndetermined(found, &geometry);
  } else if (found.homography) {
    geometry.configuration = ColmapConfiguration::kPlanarOrPanoramic;
    geometry.homography = HomographyInColmapPixels(*found.homography);
  } else {
    geometry.configuration = found.essential ? ColmapConfiguration::kCalibrated : ColmapConfiguration::kUncalibrated;
    geometry.fundamental = FundamentalInColmapPixels(found.fundamental);
    if (found.essential) geometry.essential = *found.essential;
  }
  return geometry;
}

}  // namespace diffsac
