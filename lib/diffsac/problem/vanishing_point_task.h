#pragma once

#include "diffsac/geometry/vanishing_point.h"
#include "diffsac/problem/task_description.h"

namespace diffsac {

template <>
inline constexpr const char* kModelName<VanishingPoint> = "vanishing_point";

/// The vanishing points of an image's line segments, x1 y1 x2 y2 in pixels without lens distortion; the inlier
/// threshold is the angle of VanishingPoint::Residual in degrees. Solved in normalised coordinates, K⁻¹ (x, y, 1), so
/// that a model is the direction in space, in the camera's frame, of the lines that meet in it. K is cameras->K1, or
/// SegmentCamera's guess.
struct VanishingPointTask : TaskDescriptionOf<VanishingPoint> {
  static PointMatrix Normalize(const Problem& problem, double* unit);
  static PointMatrix FeatureCoordinates(const NormalizedProblem& space);
  /// N × 2: the middles of the segments.
  static PointMatrix ImagePoints(const Problem& problem);
  /// N values in [0, 1]: the segments' lengths, relative to the image's diagonal. Longer ones are surer.
  static Eigen::VectorXd PointWeights(const Problem& problem);
  /// A segment of any direction is within the threshold so often.
  static double ChanceShare(const Problem& problem, double threshold);
  /// The vanishing point in homogeneous pixels, of unit length.
  static Eigen::Vector3d PixelPoint(const ModelParameters& model, const Problem& problem);
  /// The model of a vanishing point in homogeneous pixels.
  static ModelParameters ModelOf(const Eigen::Vector3d& pixel_point, const Problem& problem);
};

/// The calibration in which a problem's segments are solved: cameras->K1; else that of the usual focal length about the
/// middle of the image, or of the segments' box where the image's size is unknown.
Eigen::Matrix3d SegmentCamera(const Problem& problem);

}  // namespace diffsac
