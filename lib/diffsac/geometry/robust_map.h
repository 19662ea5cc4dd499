#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "diffsac/geometry/points.h"

namespace diffsac {

// What one matrix M makes of all matches, x2 ~ M x1: a rotation, of normalised coordinates, or a homography, of any.
// Points are N × 4.

/// The rows whose inliers[i] is not 0.
PointMatrix RowsOf(const PointMatrix& points, const std::vector<std::uint8_t>& inliers);

/// At most 500 of them, evenly spread: they determine such a matrix well enough for a test.
PointMatrix SpreadRows(const PointMatrix& points);

/// The diagonal of the box about the second points.
double Extent(const PointMatrix& points);

/// How far the matches are from x2 ~ M x1, in σ of a noise where both points have 1 (Mahalanobis), from `least` to
/// `greatest`, which stands too where M turns a point behind the camera.
Eigen::VectorXd MapDistances(const Eigen::Matrix3d& m, const PointMatrix& points, double least, double greatest);

double Median(Eigen::VectorXd values);

/// A weighted fit of M; false when the points leave it open.
using MapFit = bool (*)(const PointMatrix& points, const Eigen::VectorXd& weights, Eigen::Matrix3d* map);

/// argmin Σ w |R a − b|² over unit rays (Kabsch; Wahba 1965).
bool FitRotation(const PointMatrix& points, const Eigen::VectorXd& weights, Eigen::Matrix3d* rotation);
/// Homography::Fit.
bool FitHomography(const PointMatrix& points, const Eigen::VectorXd& weights, Eigen::Matrix3d* homography);

/// The fit of most of the matches (SpreadRows): by the sum of distances (MapDistances) first, which half of them may
/// spoil, then with weights that let go of those that are far from it.
bool FitRobustly(const PointMatrix& points, double least, double greatest, MapFit fit, Eigen::Matrix3d* map);

}  // namespace diffsac
