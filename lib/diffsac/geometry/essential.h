#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/model.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// Epipolar geometry of two calibrated cameras: x2ᵀ E x1 = 0 with E = [t]ₓ R, singular values (s, s, 0). Points are
/// correspondences x1 y1 x2 y2 in normalised coordinates (K⁻¹ times pixels); parameters are E, row-major, unit
/// Frobenius norm.
struct Essential : SampsonModel {
  static constexpr int kMinimalSize = 5;
  static constexpr int kMaxSolutions = 10;

  /// The 5-point algorithm (see SolveFivePoints); solutions against the oriented epipolar constraint, or with none of
  /// whose poses the five points lie before both cameras, are left out.
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);

  /// Weighted normalised 8-point algorithm, then the closest essential matrix; needs 8 points of positive weight.
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out);

  /// Weighted least squares of Sampson distances among essential matrices, from *model, by Levenberg-Marquardt: what
  /// eight linear equations lose on planes, on few points and where the camera goes forward stays. False, leaving
  /// *model, with fewer than 5 points of positive weight or unfit ones.
  static bool FitFrom(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* model);

  /// Finite, 5 distinct correspondences, in neither image all on one line.
  static bool Determined(const PointMatrix& points) { return DeterminesTwoViews(points, kMinimalSize); }

  /// Levenberg-Marquardt from *model (RefineEssential), with a weight ≥ 0 for each point, in `steps` steps at most; the
  /// loss is in the unit of `Residual`. False, leaving *model, when that does not lower the cost or the points are
  /// unfit.
  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     Parameters* model, int steps = kMostRefineSteps);
};

/// Whether for one of the four poses of E all points lie before both cameras, points[i] = x1 y1 x2 y2 in normalised
/// coordinates. Points whose rays meet at less than 1e-3 rad have no say: noise would decide. R and t in closed form
/// (Horn, "Recovering baseline and orientation from essential matrix", 1990).
bool SatisfiesCheirality(const Eigen::Matrix3d& e, const double (*points)[4], int count);

/// All real solutions of the 5-point problem, up to 10, without the orientation test.
///
/// Nistér, "An efficient solution to the five-point relative pose problem", PAMI 2004: E is a combination of the four
/// null vectors of the epipolar equations; det E = 0 and 2 E Eᵀ E = tr(E Eᵀ) E are ten cubics in its three unknowns,
/// which elimination turns into one polynomial of degree 10. Each root is then polished on the cubics themselves by
/// Gauss-Newton steps, because the elimination loses digits near degenerate sets. No memory on the heap.
int SolveFivePoints(const PointMatrix& points, const int* set, Matrix3Parameters* out);
/// The same of points[i] = x1 y1 x2 y2; `possible`: only solutions that a scene before both cameras can have.
int SolveFivePoints(const double (*points)[4], bool possible, Matrix3Parameters* out);

/// The nearest essential matrix in the Frobenius norm: singular values (s, s, 0), s the mean of the two largest.
Eigen::Matrix3d ClosestEssential(const Eigen::Matrix3d& e);

}  // namespace diffsac
