#pragma once

#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "lab/ground_truth/example.h"

namespace diffsac {

/// CLNet's adaptive temperature of each point (docs/clnet.md), [B, M]. distances: [B, M], in multiples of ε; inliers:
/// [B, M], 0 or 1.
torch::Tensor AdaptiveTemperature(const torch::Tensor& distances, const torch::Tensor& inliers, double alpha);

/// Cross-entropy of temperature · logits; inliers and outliers of a problem weigh the same, whatever their numbers.
/// All [B, M]; mask: bool.
torch::Tensor BalancedCrossEntropy(const torch::Tensor& logits, const torch::Tensor& inliers,
                                   const torch::Tensor& temperature, const torch::Tensor& mask);

/// A weighted linear fit that gradients pass through, in double precision: the LinearEquations of the task
/// (lab/ground_truth).
struct LinearFit {
  torch::Tensor rows;
  std::int64_t rows_per_point = 1;
  bool about_mean = false;
  torch::Tensor truth;  ///< A unit vector; undefined without a truth.
};

/// What the regression loss needs of one problem. Throws Error for a task whose description has no equations.
LinearFit MakeLinearFit(const Example& example);

/// 1 − (v · v*)² averaged over problems with a truth, v the unit vector that minimises Σ w (row · v)²: 0 for the true
/// model, 1 for one that has nothing of it. A fit that the weights leave undetermined counts 0 and has no gradient.
/// weights: [B, N] ≥ 0, differentiable.
torch::Tensor RegressionLoss(const torch::Tensor& weights, const std::vector<LinearFit>& fits);

}  // namespace diffsac
