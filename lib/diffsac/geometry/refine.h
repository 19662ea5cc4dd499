#pragma once

#include <Eigen/Core>

#include "diffsac/core/status.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/two_view.h"

namespace diffsac {

struct RefineOptions {
  RobustLoss loss{LossKind::kTruncated, 1.0};  ///< its scale is linear, in the unit of the points
  int max_iterations = 25;                     ///< steps tried, taken or not
  /// Stop when a step lowers the cost by less than this share, or when all steps are shorter than this (radians).
  double relative_tolerance = 1e-8;
};

struct RefineReport {
  /// kTooFewPoints: fewer points of positive weight than the model has degrees of freedom need (7, 5, 4);
  /// kDegenerate: points, weights or the model not finite, weights negative, or an image's points all equal.
  /// The model is as it was in both cases.
  Status status = Status::kOk;
  int iterations = 0;         ///< steps tried
  double initial_cost = 0.0;  ///< Σ weight ρ(residual²), in the points' unit squared
  double final_cost = 0.0;    ///< never above initial_cost; equal to it when the model is unchanged
};

/// What a homography's refinement minimises: TransferError (second image) or HomographySampsonError.
enum class HomographyResidual { kTransfer, kSampson };

/// Levenberg-Marquardt on the model's own manifold (manifolds.h), starting from *model: minimises the weighted, robust
/// sum of squared Sampson distances (F, E, H) or transfer distances (H), with exact derivatives and iteratively
/// reweighted losses (Triggs et al., "Bundle adjustment: a modern synthesis", 2000). Coordinates are normalised inside
/// (not for E, whose points already are); a model off the manifold is first projected. Memory is allocated once, not by
/// iteration.
RefineReport RefineHomography(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                              HomographyResidual error, Matrix3Parameters* model);
RefineReport RefineFundamental(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                               Matrix3Parameters* model);
RefineReport RefineEssential(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                             Matrix3Parameters* model);

}  // namespace diffsac
