#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/model.h"
#include "diffsac/geometry/robust_loss.h"

namespace diffsac {

/// A vanishing point: a unit vector v of either sign on the Gaussian sphere (Barnard, "Interpreting perspective
/// images", Artificial Intelligence 1983), in homogeneous coordinates of the image plane of the points. Points are line
/// segments x1 y1 x2 y2 by their ends, best in coordinates of about unit size. Minimal sets of 2 segments: where their
/// lines meet, be it at infinity.
///
/// `Residual` is the sine of the angle at the segment's middle between the segment and the line to the vanishing point,
/// whose 1 − cos is the consistency of Kluger et al. ("CONSAC", CVPR 2020). It is 1, the largest there is, for a
/// segment of length 0 or about the vanishing point, whose direction says nothing.
struct VanishingPoint {
  using Parameters = Eigen::Vector3d;
  static constexpr int kDimension = 4;
  static constexpr int kMinimalSize = 2;
  static constexpr int kMaxSolutions = 1;
  /// Of an angle, for MAGSAC++.
  static constexpr int kResidualDof = 1;

  /// 0 for segments on one line, or of length 0.
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);

  /// The vanishing point of least weighted squared residuals: Levenberg-Marquardt on the sphere from the point that is
  /// nearest to all lines (the least eigenvector of Σ w n nᵀ, n the unit normals of the planes through the segments).
  /// False for fewer than 2 segments of positive weight, or all on one line.
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out);

  /// Finite, and not all of the segments that have a length on one line.
  static bool Determined(const PointMatrix& points);

  static double Residual(const Parameters& model, const double* point);

  /// As `Residual`, over 4 columns.
  static void Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out);

  /// Levenberg-Marquardt on the sphere of the weighted loss of all segments; at most so many `steps`. False, leaving
  /// *model, when that does not lower the cost.
  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     Parameters* model, int steps = kMostRefineSteps);
};

}  // namespace diffsac
