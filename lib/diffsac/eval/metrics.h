#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "diffsac/data/problem.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// The angular error that a failed estimate counts as: the largest angle between two hyperplanes.
inline constexpr double kWorstAngleDeg = 90.0;

/// How wrong one estimate is; NaN where the ground truth is unknown or the task has no such error.
struct EstimateError {
  /// Lines, planes: between the normals, in [0, 90]. F, E: the larger of rotation_deg and translation_deg.
  double angle_deg = std::numeric_limits<double>::quiet_NaN();
  /// Lines, planes, in the data's unit: difference of the two models' signed distances at the centroid of all points of
  /// the problem, normals turned to the same side. A failure counts as the diagonal of the points' bounding box.
  double offset = std::numeric_limits<double>::quiet_NaN();
  bool failed = false;  ///< No model, or one with a non-finite value.
  double rotation_deg = std::numeric_limits<double>::quiet_NaN();     ///< F, E: in [0, 180]
  double translation_deg = std::numeric_limits<double>::quiet_NaN();  ///< F, E: of the direction, either sign, [0, 90]
  /// H: mean distance |H x − H_true x| in image 2 over the pixels of image 1 that both images show. F and E where no
  /// pose is known: mean Sampson distance of the true inliers. A failure is infinite.
  double error_px = std::numeric_limits<double>::quiet_NaN();
};

/// The c of mAA@c with its unit.
struct Tolerance {
  double value;
  bool pixels = false;
  Tolerance(double degrees) : value(degrees) {}
  Tolerance(double c, bool in_pixels) : value(c), pixels(in_pixels) {}
};

/// The error that a task's tables are about: error_px where the tolerance is in pixels, else angle_deg.
double MainError(const EstimateError& error, const Tolerance& tolerance);

/// AverageAccuracy in degrees. In pixels: the mean over 10 thresholds from 1 px to c, evenly spaced in their logarithms,
/// of [error ≤ threshold] (Jin et al., "Image Matching across Wide Baselines", IJCV 2021, homographies).
double AverageAccuracyWithin(double error, const Tolerance& tolerance);

/// Compares an estimate with the truth. A failure is the worst error; it is never left out.
EstimateError MeasureError(const Estimate& estimate, const Example& example);

/// Accuracy of one error within a tolerance: the mean over k = 1..10 of [error ≤ k·c/10], ties count as accurate.
double AverageAccuracy(double error, double threshold);

/// mAA@c, the mean of AverageAccuracy over the problems. Non-finite errors are accurate at no threshold.
/// NaN for no errors. (The CVPR 2020 RANSAC tutorial's definition with thresholds scaled to c.)
double MeanAverageAccuracy(std::span<const double> errors, double threshold);

/// Exact AUC@c: area under the recall over the sorted errors, trapezoids from (0, 0), clipped at c and divided by c
/// (Sarlin et al., SuperGlue, CVPR 2020, `pose_auc`). NaN for no errors.
double AreaUnderCurve(std::span<const double> errors, double threshold);

/// acc@c, the share of errors ≤ c. NaN for no errors.
double AccuracyWithin(std::span<const double> errors, double threshold);

/// The middle value, or the mean of the middle two. Infinities rank last; NaN values are left out. NaN for no values.
double Median(std::vector<double> values);

/// The arithmetic mean; NaN for no values.
double Mean(std::span<const double> values);

}  // namespace diffsac
