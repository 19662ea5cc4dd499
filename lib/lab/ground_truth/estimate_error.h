#pragma once

#include <limits>
#include <vector>

namespace diffsac {

/// The worst errors, which a failure counts as: of two hyperplanes, of a rotation, of a direction of either sign.
inline constexpr double kWorstAngleDeg = 90.0;
inline constexpr double kWorstRotationDeg = 180.0;
inline constexpr double kWorstTranslationDeg = 90.0;
/// Of the pose that a person is given: of a rotation, and of a direction with its sign.
inline constexpr double kWorstPoseDeg = 180.0;

/// How wrong one estimate is (docs/metrics.md); NaN where the ground truth is unknown or the task has no such error.
struct EstimateError {
  /// Lines, planes: between the normals, in [0, 90]. F, E: the larger of rotation_deg and translation_deg.
  double angle_deg = std::numeric_limits<double>::quiet_NaN();
  /// Lines, planes, in the data's unit.
  double offset = std::numeric_limits<double>::quiet_NaN();
  bool failed = false;                                                ///< No model, or one with a non-finite value.
  double rotation_deg = std::numeric_limits<double>::quiet_NaN();     ///< F, E: in [0, 180]
  double translation_deg = std::numeric_limits<double>::quiet_NaN();  ///< F, E: of the direction, either sign, [0, 90]
  /// H: HomographyError. F and E where no pose is known: mean Sampson distance of the true inliers.
  double error_px = std::numeric_limits<double>::quiet_NaN();
  /// Of an unknown focal length, relative; infinite for a failure.
  double focal = std::numeric_limits<double>::quiet_NaN();
  /// Several structures: per cent of the points whose label is not the true one's.
  double misclassified = std::numeric_limits<double>::quiet_NaN();
  /// The same: share of the true structures that are found.
  double recall = std::numeric_limits<double>::quiet_NaN();
  /// The same: InstanceAngles.
  std::vector<double> instance_angles_deg = {};
  /// Two views: AddPoseError, of R, of t with its sign, and the larger of the two.
  double pose_rotation_deg = std::numeric_limits<double>::quiet_NaN();
  double pose_translation_deg = std::numeric_limits<double>::quiet_NaN();
  double pose_deg = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace diffsac
