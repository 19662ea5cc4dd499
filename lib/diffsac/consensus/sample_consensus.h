#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "diffsac/consensus/consensus_options.h"
#include "diffsac/consensus/model_hooks.h"
#include "diffsac/consensus/samplers/minimal_sampler.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/geometry/robust_loss.h"

namespace diffsac {

struct ConsensusResult {
  Status status = Status::kNoModel;
  ModelParameters model;
  std::vector<std::uint8_t> inliers;  ///< residual ≤ inlier_threshold under the returned model, exactly
  double inlier_threshold =
      std::numeric_limits<double>::quiet_NaN();  ///< ε, or less where options.threshold is adaptive
  /// Of a model of two minima: the other one, where it is as good.
  std::optional<ModelParameters> other = {};
  int other_inliers = 0;  ///< Of a rival (model_hooks.h): those that are no inliers of the model.
  /// Of a model with unknown focal lengths, where priors of them are given; in the units of the points.
  std::optional<FocalPosteriors> focal = {};
  double score = 0.0;  ///< of the returned model, by the score that chose it last
  /// σ of the inliers' residuals, one coordinate's (NoiseOfInliers in geometry/covariance.h); NaN without a model, or
  /// with γ inliers alone.
  double noise_scale = std::numeric_limits<double>::quiet_NaN();
  /// How the model was refined, in the unit of the points; nothing without a final refinement.
  std::optional<FitConditions> fit = {};
  int hypotheses = 0;  ///< models solved or fitted, all stages: each set, each least squares
  int unique_minimal_sets = 0;
  /// The first (up to kReportedSets) minimal sets that were drawn, for reports of what a sampler proposes.
  std::vector<std::vector<int>> first_sets;
  std::int64_t iterations = 0;            ///< minimal sets drawn
  StopReason stop = StopReason::kNotRun;  ///< why there were no more
};

/// What is known of a problem beside its points: extra hypotheses, and what scores take into account.
struct EstimationPriors {
  /// Models to score along with the solved ones (already paid for by the caller, so not counted as hypotheses again).
  std::vector<ModelParameters> models;
  /// Weights for one weighted least-squares hypothesis (N values ≥ 0; empty: none); counts as one hypothesis.
  Eigen::VectorXd fit_weights;
  /// The probability of each point to be an inlier, for options.inlier_prior_power (N values; empty: unknown).
  Eigen::VectorXd inlier_priors = {};
  /// How much each point says (PointWeights in problem/problem.h), for structures.search: chosen. Empty: alike.
  Eigen::VectorXd point_weights = {};
  std::optional<CameraPrior> cameras = {};
  /// The cosine and sine of how each keypoint turned, N × 2 (Problem::similarities), for options.turn_weight. Empty:
  /// unknown.
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
