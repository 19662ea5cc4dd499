#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/ransac/consensus_options.h"
#include "diffsac/ransac/consensus_result.h"
#include "diffsac/ransac/model_hooks.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac {

/// What is known of a problem beside its points: extra hypotheses, and what scores take into account.
struct EstimationPriors {
  /// Models to score along with the solved ones (already paid for by the caller, so not counted as hypotheses again).
  std::vector<ModelParameters> models;
  /// Weights for one weighted least-squares hypothesis (N values ≥ 0; empty: none); counts as one hypothesis.
  Eigen::VectorXd fit_weights;
  /// The probability of each point to be an inlier, for options.inlier_prior_power (N values; empty: unknown).
  Eigen::VectorXd inlier_priors = {};
  /// How much each point says (PointWeights in problem/problem.h), for instances.search: chosen. Empty: alike.
  Eigen::VectorXd point_weights = {};
  std::optional<CameraPrior> cameras = {};
  /// The cosine and sine of how each keypoint turned, N × 2 (Problem::scale_rotation_changes), for
  /// options.keypoint_orientation_weight. Empty: unknown.
  PointMatrix turns = {};
  /// Of how many of the data's units one unit of the points is.
  double unit = 1.0;
};

/// The loop: minimal sets → solve → score → (local optimisation) → refit. Priors are considered first, which makes a
/// good one save work; they count as no draws. Then sets are drawn from the sampler until options.stopping says so, in
/// blocks, solved and scored by up to `threads` threads (0: all cores) and taken in their order: the best is the
/// highest score with the lowest index, and the result is the same bit for bit for any number of threads and any block
/// size. Local optimisation, the sequential test and degeneracy hooks draw from rng.
///
/// points: those that CheckPoints<Model> passes. kNoModel: every set was degenerate, there were none, or ε or a length
/// that the options make of it is beyond [kLeastScale, kLargestScale]. A model supported by its own minimal set alone
/// is still kOk. Sets with an index out of range are skipped as degenerate.
template <MinimalModel Model>
ConsensusResult SearchCheckedPoints(const PointMatrix& points, double inlier_threshold, MinimalSampler& sampler,
                                    const ConsensusOptions& options, const Rng& rng,
                                    const EstimationPriors& priors = {}, int threads = 1);

/// SearchCheckedPoints of any points. Never throws for bad data: fewer than γ points, non-finite values and degenerate
/// data give a status.
template <MinimalModel Model>
ConsensusResult SampleConsensus(const PointMatrix& points, double inlier_threshold, MinimalSampler& sampler,
                                const ConsensusOptions& options, const Rng& rng, const EstimationPriors& priors = {},
                                int threads = 1) {
  ConsensusResult failed;
  failed.status = CheckPoints<Model>(points);
  if (failed.status != Status::kOk) return failed;
  return SearchCheckedPoints<Model>(points, inlier_threshold, sampler, options, rng, priors, threads);
}

/// residual ≤ threshold for each point.
template <MinimalModel Model>
std::vector<std::uint8_t> InlierMask(const PointMatrix& points, const typename Model::Parameters& model,
                                     double threshold) {
  const Eigen::VectorXd residuals = RowResiduals<Model>(points, model);
  std::vector<std::uint8_t> mask(points.rows());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = residuals[i] <= threshold;
  return mask;
}

}  // namespace diffsac
