#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/noise_of_inliers.h"
#include "diffsac/geometry/points.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/robust_loss.h"

namespace diffsac {

/// Σ w JᵀJ over residuals, p × p, J being their derivatives by the model's p parameters, for N weights w.
using InformationFunction = std::function<Eigen::MatrixXd(const Eigen::VectorXd& weights)>;

/// The covariance of a model's p parameters, p × p, from the information of its inliers and the scale of their noise:
///
///   Σ = c σ² A⁻¹ B A⁻¹,   A = Σ w JᵀJ,   B = Σ w² JᵀJ over the inliers
///
/// as of an M-estimate of Gaussian noise (Huber, "Robust statistics", 1981, ch. 6). σ, one coordinate's, is that of the
/// Gaussian whose residuals within the threshold have the mean square of the inliers', p of their values being the
/// model's; c is what the loss wastes: 1 for least squares of all points, 1.1 for a loss truncated at 2.5 σ, more where
/// it bends earlier. Where NoiseOfInliers is below a fifth of the threshold, that is σ, and residuals beyond 3 σ, which
/// are no such noise, add to B the square of what each pulls.
///
/// noise: what of Σ w JᵀJ noise of σ = 1 makes where J is taken at noisy points; it is left out of A. Empty: nothing.
///
/// residuals: N lengths of d = residual_dimension values each (1: Sampson, 2: reprojection, 3: of points in space).
/// Nothing where the inliers are no more than determine the model, where they leave a direction open, where they fit
/// exactly, where the noise is greater than the threshold, or anything is not finite.
std::optional<Eigen::MatrixXd> CovarianceOfFit(const Eigen::VectorXd& residuals, int residual_dimension,
                                               const FitConditions& fit, const InformationFunction& information,
                                               const InformationFunction& noise = {});

/// d [t]ₓ exp([ω]ₓ) R / d (ω, t) at ω = 0, nine entries row by row.
Eigen::Matrix<double, 9, 6> EssentialByPose(const RelativePose& pose);

/// CovarianceOfFit of the relative pose of two calibrated views by squared Sampson distances, in the order (ω, t): the
/// truth is R = exp([ω]ₓ) R̂, ω in radians in the frame of the second camera, and t̂ + δ, |t̂| = 1, in that frame. 6 × 6
/// of rank 5: δ is orthogonal to t̂, radians too. points: N × 4, normalised coordinates.
std::optional<Eigen::MatrixXd> RelativePoseCovariance(const PointMatrix& points, const RelativePose& pose,
                                                      const FitConditions& fit);

/// The same of a calibrated camera in a known scene by squared reprojection errors: 6 × 6, R = exp([ω]ₓ) R̂, ω in
/// radians in the camera's frame, t = t̂ + δ in the scene's unit. points: N × 5.
std::optional<Eigen::MatrixXd> AbsolutePoseCovariance(const PointMatrix& points, const AbsolutePose::Parameters& pose,
                                                      const FitConditions& fit);

}  // namespace diffsac
