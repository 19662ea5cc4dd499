#pragma once

#include <Eigen/Core>
#include <optional>

#include "diffsac/geometry/model.h"
#include "diffsac/geometry/robust_loss.h"

namespace diffsac {

/// The motion between two clouds by matched points: y = s R x + t, with s = 1 or, `kScaled`, any s > 0. Points are
/// x1 x2 x3 y1 y2 y3, in the clouds' units; parameters are [s R | t], 3 × 4, row-major, R a rotation: a mirrored cloud
/// has no model. Minimal sets of 3 points.
template <bool kScaled>
struct CloudMotion {
  using Parameters = Eigen::Matrix<double, 12, 1>;
  static constexpr bool kHasScale = kScaled;
  static constexpr int kDimension = 6;
  static constexpr int kResidualDimension = 3;  ///< Of what `Residual` is the length of.
  static constexpr int kResidualDof = 3;        ///< For MAGSAC++.
  static constexpr int kFreedom = kScaled ? 7 : 6;
  static constexpr int kMinimalSize = 3;
  static constexpr int kMaxSolutions = 1;
  /// Two motions may explain the matches of a symmetric thing equally well (ransac/model_hooks.h).
  static constexpr bool kHasRivals = !kScaled;

  /// Least squares of the three; none where they lie on one line.
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out);

  /// The least Σ w |s R x + t − y|², in closed form (Umeyama, "Least-squares estimation of transformation parameters
  /// between two point patterns", PAMI 1991, who adds the scale to Kabsch 1976 and Horn 1987). False where the points
  /// of positive weight lie on one line.
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out);

  /// Finite, and neither cloud all on one line.
  static bool Determined(const PointMatrix& points);

  /// |s R x + t − y|, in the second cloud's unit.
  static double Residual(const Parameters& model, const double* point);
  /// As `Residual`, over 6 columns.
  static void Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out);

  /// Levenberg-Marquardt on SE(3), or with the logarithm of s, from *model; at most `steps` steps. A loss without pull
  /// beyond its scale is looked at up to thrice that. False when *model stays as it was.
  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     Parameters* model, int steps = kMostRefineSteps);

  using Information = Eigen::Matrix<double, kFreedom, kFreedom>;
  /// Σ weight JᵀJ by (ω, δ) or (ω, δ, log s): R ← exp([ω]ₓ) R, t ← t + δ.
  static Information InformationOf(const PointMatrix& points, const Eigen::VectorXd& weights, const Parameters& model);
};

using Rigid = CloudMotion<false>;
using Similarity = CloudMotion<true>;

/// s of the parameters of a similarity; 1 for a rigid motion.
double ScaleOf(const Similarity::Parameters& model);

/// CovarianceOfFit (covariance.h) of a motion between clouds by squared distances: 6 × 6 in the order (ω, t), or with
/// the scale 7 × 7 in the order (ω, t, log s); ω in radians in the second cloud's frame, t in its unit. points: N × 6.
template <bool kScaled>
std::optional<Eigen::MatrixXd> MotionCovariance(const PointMatrix& points, const Rigid::Parameters& model,
                                                const FitConditions& fit);

extern template struct CloudMotion<false>;
extern template struct CloudMotion<true>;

}  // namespace diffsac
