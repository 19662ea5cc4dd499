#pragma once

#include "diffsac/problem/problem.h"

namespace diffsac {

/// Centred on the coordinate-wise median, divided by the median distance from it (the mean distance where more than
/// half of the points are equal; 1 where all are).
PointMatrix CentredCoordinates(const PointMatrix& points);

/// The calibration of an image of this size with a focal length in pixels about its middle.
Eigen::Matrix3d CentredCamera(double focal, const ImageSize& size);

/// Matches without the images' sizes and focal lengths: K⁻¹ x in each image where the calibration is known (and used);
/// else (x − centre of the image) / (1.2 · longer side), the usual focal length, where both sizes are; else each
/// image's points as CentredCoordinates.
PointMatrix MatchCoordinates(const Problem& problem, bool use_calibration = true);

}  // namespace diffsac
