#pragma once

// What sample_consensus.h declares: the loop (loop.h) with the policies that the options name, for the files that
// instantiate it for a model.

#include <vector>

#include "diffsac/ransac/local/final_refiner.h"
#include "diffsac/ransac/local/local_optimizer.h"
#include "diffsac/ransac/loop.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/scores/scorer.h"

namespace diffsac {

/// What scores take into account of the priors. Priors that are not one number a point say nothing; what is no
/// probability counts as the nearest one, and what is no number as 0.
ScorePrior ScorePriorOf(const EstimationPriors& priors, const ConsensusOptions& options, Eigen::Index num_points);

/// A scorer with its score, as the loop asks for it.
template <MinimalModel Model>
struct ModelScore {
  const Scorer<Model>& scorer;
  const Score& score;
  double operator()(const typename Model::Parameters& model, double score_to_beat) const {
    return scorer(model, score, score_to_beat);
  }
  Eigen::VectorXd Residuals(const typename Model::Parameters& model) const { return scorer.Residuals(model); }
};

/// The models of the priors, that of their weights last.
template <MinimalModel Model>
std::vector<typename Model::Parameters> GivenModels(const PointMatrix& points, const EstimationPriors& priors) {
  std::vector<typename Model::Parameters> given;
  for (const ModelParameters& hint : priors.models)
    if (hint.size() == Model::Parameters::SizeAtCompileTime && hint.allFinite()) given.emplace_back(hint);
  typename Model::Parameters fitted;
  if (priors.fit_weights.size() > 0 && Model::Fit(points, priors.fit_weights, &fitted)) given.push_back(fitted);
  return given;
}

template <MinimalModel Model>
ransac::LoopOptions LoopOptionsOf(const ConsensusOptions& options, const NoiseScales& scales, int threads) {
  // Of a model that may have rivals, for which there would be no room, most inliers are common.
  constexpr double kSameRival = 0.5;
  return {.max_iterations = options.max_iterations,
          .num_threads = threads,
          .block_size = options.block_size,
          .candidates = options.refit_candidates,
          .threshold = scales.score_threshold,
          .alike = HasRivals<Model>        ? kSameRival
                   : options.lo_starts > 0 ? ransac::kSameOptimum
                                           : 1.0,
          .lo_starts = options.lo_starts,
          .lo_restarts = options.lo_restarts};
}

/// SearchCheckedPoints with a stopping rule of the caller's.
template <MinimalModel Model>
ConsensusResult SearchUntil(StoppingRule stop, const PointMatrix& points, double inlier_threshold,
                            MinimalSampler& sampler, const ConsensusOptions& options, const Rng& rng,
                            const EstimationPriors& priors, int threads) {
  const NoiseScales scales = ScalesOf<Model>(points, inlier_threshold, options, priors.unit);
  if (!scales.Usable()) return {};
  const Scorer<Model> scorer(points, ScorePriorOf(priors, options, points.rows()));
  const Score score = scales.MakeScore(options.score, options.inlier_prior);
  const ModelScore<Model> scored{scorer, score};
  LocalOptimizer<Model> optimize(scorer, score, options, scales, rng);
  const FinalRefiner<Model> refine(scorer, options, scales);
  const auto given = GivenModels<Model>(points, priors);
  ConsensusResult result = ransac::Search<Model>(points, ransac::Policies{sampler, scored, optimize, stop, refine},
                                                 LoopOptionsOf<Model>(options, scales, threads), given);
  result.hypotheses += priors.fit_weights.size() > 0 ? 1 : 0;
  return result;
}

template <MinimalModel Model>
ConsensusResult SearchCheckedPoints(const PointMatrix& points, double inlier_threshold, MinimalSampler& sampler,
                                    const ConsensusOptions& options, const Rng& rng, const EstimationPriors& priors,
                                    int threads) {
  const StoppingRule stop(options, points.rows(), Model::kMinimalSize);
  return SearchUntil<Model>(stop, points, inlier_threshold, sampler, options, rng, priors, threads);
}

}  // namespace diffsac
