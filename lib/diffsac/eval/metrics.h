#pragma once

#include <span>
#include <vector>

#include "diffsac/data/problem.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// The angular error that a failed estimate counts as: the largest angle between two hyperplanes.
inline constexpr double kWorstAngleDeg = 90.0;

/// How wrong one estimate is. Both values are NaN when the ground truth is unknown.
struct EstimateError {
  double angle_deg = 0.0;  ///< Between the normals, in [0, 90].
  /// In the data's unit: difference of the two models' signed distances at the centroid of all points of the problem,
  /// normals turned to the same side. A failure counts as the diagonal of the points' bounding box.
  double offset = 0.0;
  bool failed = false;  ///< No model, or one with a non-finite value.
};

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
