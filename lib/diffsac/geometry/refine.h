#pragma once

#include <Eigen/Core>

#include "diffsac/core/status.h"
#include "diffsac/geometry/focal.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/two_view.h"
#include "diffsac/geometry/unknown_focal.h"

namespace diffsac {

struct RefineOptions {
  RobustLoss loss{LossKind::kTruncated, 1.0};  ///< its scale is linear, in the unit of the points
  int max_iterations = kMostRefineSteps;       ///< steps tried, taken or not
  /// Stop when a step lowers the cost by less than this share, or when all steps are shorter than this (radians).
  double relative_tolerance = 1e-8;
};

/// Points beyond this many scales of the loss sit out of a refinement, for speed.
inline constexpr double kRefineReach = 3.0;

struct RefineReport {
  /// kTooFewPoints: fewer points of positive weight than the model has degrees of freedom need (7, 5, 4);
  /// kDegenerate: points, weights or the model not finite, weights negative, or an image's points all equal.
  /// The model is as it was in both cases.
  Status status = Status::kOk;
  int iterations = 0;         ///< steps tried
  double initial_cost = 0.0;  ///< Σ weight ρ(residual²), in the points' unit squared
  double final_cost = 0.0;    ///< never above initial_cost; equal to it when the model is unchanged
};

/// Levenberg-Marquardt on the model's own manifold (manifolds.h), starting from *model: minimises the weighted, robust
/// sum of squared Sampson distances (SampsonError, HomographySampsonError), with exact derivatives and iteratively
/// reweighted losses (Triggs et al., "Bundle adjustment: a modern synthesis", 2000). Coordinates are normalised inside
/// (not for E, whose points already are); a model off the manifold is first projected. Memory is allocated once, not by
/// iteration.
RefineReport RefineHomography(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                              Matrix3Parameters* model);
RefineReport RefineFundamental(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                               Matrix3Parameters* model);
RefineReport RefineEssential(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                             Matrix3Parameters* model);

/// The same of E and the focal lengths (FocalManifold); costs are without the priors' share. A prior, log-normal about
/// its `focal`, weighs as much as it should beside residuals whose variance is what it is at the start
/// (ResidualVariance), nothing with log_sigma = 0; where there is one length, that of the second image counts.
/// RefineWithFocal leaves the lengths as they are.
RefineReport RefineFocal(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                         const RefineOptions& options, const FocalPriors& priors, FocalParameters* model);
RefineReport RefineWithFocal(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                             const RefineOptions& options, FocalParameters* model);

/// The κ for which the cost / 2κ has the curvature of a log-likelihood, whatever the loss and the noise: the variance
/// of residuals r where all count alike, else Σ w² ψ² / Σ w ψ' with ψ = r ρ'(r²) (Huber's sandwich), of residuals whose
/// distances are given. `free`: how many residuals the model takes for itself. 0 when nothing is left.
double ResidualVariance(const RobustLoss& loss, const double* distances, const double* weights, int count, int free);

}  // namespace diffsac
