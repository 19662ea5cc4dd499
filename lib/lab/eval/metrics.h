#pragma once

#include <span>
#include <string>
#include <vector>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/ground_truth/estimate_error.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// The c of mAA@c with its unit.
struct Tolerance {
  double value;
  bool pixels = false;
  Tolerance(double degrees) : value(degrees) {}
  Tolerance(double c, bool in_pixels) : value(c), pixels(in_pixels) {}
};

/// The error that a task's tables are about: error_px where the tolerance is in pixels, else angle_deg.
double MainError(const EstimateError& error, const Tolerance& tolerance);

/// AverageAccuracy in degrees. In pixels: the mean over 10 thresholds from 1 px to c, evenly spaced in their
/// logarithms, of [error ≤ threshold] (Jin et al., "Image Matching across Wide Baselines", IJCV 2021, homographies).
double AverageAccuracyWithin(double error, const Tolerance& tolerance);

/// What tables, intervals and differences take for one problem's accuracy: the recall where there are several
/// structures, else AverageAccuracyWithin of the main error. NaN without ground truth.
double AccuracyOf(const EstimateError& error, const Tolerance& tolerance);

/// Compares an estimate with the truth, as the task's description does (problem/task_description.h), and with several
/// true structures (instances_error.h). A failure is the worst error; it is never left out.
EstimateError MeasureError(const Estimate& estimate, const Example& example);

/// Accuracy of one error within a tolerance: the mean over k = 1..10 of [error ≤ k·c/10], ties count as accurate.
/// (The CVPR 2020 RANSAC tutorial's definition with thresholds scaled to c.)
double AverageAccuracy(double error, double threshold);

/// The middle value, or the mean of the middle two. Infinities rank last; NaN values are left out. NaN for no values.
double Median(std::vector<double> values);

/// The arithmetic mean; NaN for no values.
double Mean(std::span<const double> values);

}  // namespace diffsac
