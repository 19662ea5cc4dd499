#pragma once

#include <Eigen/Core>

#include "diffsac/core/random.h"
#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/model.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

/// Epipolar geometry of two uncalibrated images: x2ᵀ F x1 = 0, rank 2. Points are correspondences x1 y1 x2 y2 in pixels
/// (any unit); parameters are F, row-major, unit Frobenius norm. Minimal sets of 7 points.
struct Fundamental : SampsonModel {
  static constexpr int kMinimalSize = 7;
  static constexpr int kMaxSolutions = 3;

  /// The 7-point algorithm (Hartley and Zisserman, ch. 11.1.2) on normalised points: the real roots of
  /// det(α F₁ + β F₂) = 0 over the null space. Solutions against the oriented epipolar constraint are left out.
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);

  /// Weighted normalised 8-point algorithm, then the closest matrix of rank 2; needs 8 points of positive weight.
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out);

  /// Finite, 7 distinct correspondences, in neither image all on one line.
  static bool Determined(const PointMatrix& points) { return DeterminesTwoViews(points, kMinimalSize); }

  /// Levenberg-Marquardt from *model (RefineFundamental), with a weight ≥ 0 for each point, in `steps` steps at most;
  /// the loss is in the unit of `Residual`. False, leaving *model, when that does not lower the cost or the points are
  /// unfit.
  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     Parameters* model, int steps = kMostRefineSteps);

  /// (s₁ − s₂)/s₂ of the essential matrix K2ᵀ F K1, whose singular values s₁ ≥ s₂ are equal for the true cameras.
  static double CameraMismatch(const Parameters& model, const Eigen::Matrix3d& K1, const Eigen::Matrix3d& K2);

  /// DEGENSAC: when all but two or fewer of the set `model` was solved from are on one plane, up to kMaxSolutions
  /// models by plane and parallax (RecoverFromPlane); 0 otherwise.
  static int RecoverFromDegeneracy(const PointMatrix& points, const int* set, const Parameters& model, double threshold,
                                   Rng rng, Parameters* out, int* fits);
};

/// The same model from minimal sets of 8 points (Longuet-Higgins, Nature 1981; Hartley, PAMI 1997): one solution, the
/// null vector made rank 2.
struct Fundamental8 : Fundamental {
  static constexpr int kMinimalSize = 8;
  static constexpr int kMaxSolutions = 1;

  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);
  static bool Determined(const PointMatrix& points) { return DeterminesTwoViews(points, kMinimalSize); }
  static int RecoverFromDegeneracy(const PointMatrix& points, const int* set, const Parameters& model, double threshold,
                                   Rng rng, Parameters* out, int* fits);
};

/// All real solutions of the 7-point problem, up to 3, without the orientation test.
int SolveSevenPoints(const PointMatrix& points, const int* set, Matrix3Parameters* out);

}  // namespace diffsac
