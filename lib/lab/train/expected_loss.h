#pragma once

#include <torch/types.h>

#include <span>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/problem/problem.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// Distances of all points from the ground-truth model, of several structures from the nearest, in multiples of ε
/// (N values): residuals in the space that the model is solved in. Empty where the truth has no model.
std::vector<double> TruthDistances(const Example& example);

/// The distribution that NG-RANSAC starts from: exp(−r² / 2σ²) of the distances r from the ground-truth model, σ in
/// multiples of ε, over their sum. Without a true model the marked inliers are equally likely; without those either, or
/// where nothing is near the model, all points are.
std::vector<float> TargetDistribution(const Example& example, double sigma);

/// Mean over problems of KL(target || p) in nats. log_weights, target: [B, N]; the target is 0 for padding.
torch::Tensor TargetDivergence(const torch::Tensor& log_weights, const torch::Tensor& target);

/// `count` minimal sets drawn without replacement with p = exp(log_weights), point after point, in the order of
/// drawing: top-γ of log_weights plus Gumbel noise (Kool et al., "Stochastic beams and where to find them", ICML 2019).
std::vector<int> DrawOrderedSets(std::span<const float> log_weights, int set_size, int count, Rng rng);

/// log of the probability of ordered sets drawn so: Σ log p(y_m) − log(1 − Σ_{l<m} p(y_l)) (Plackett-Luce).
/// log_weights: [B, N]; sets: [B, S, γ], long. Returns [B, S].
torch::Tensor OrderedSetLogProbability(const torch::Tensor& log_weights, const torch::Tensor& sets);

/// A loss whose gradient is an unbiased estimate of that of the expected loss (REINFORCE, Williams 1992): the mean of
/// (ℓ − baseline) log p. The baseline of a draw is the mean of the others of its problem. log_probability: [B, K];
/// losses: [B, K], K ≥ 2, no gradient.
torch::Tensor ExpectedLossSurrogate(const torch::Tensor& log_probability, const torch::Tensor& losses);

}  // namespace diffsac
