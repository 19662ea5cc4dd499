#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "diffsac/consensus/sample_consensus.h"

namespace diffsac::testing {

/// The loop over uniform sets, drawn from the same generator as the rest.
template <MinimalModel Model>
ConsensusResult SearchUniformly(const PointMatrix& points, double threshold, const ConsensusOptions& options,
                                const Rng& rng, const EstimationPriors& priors = {}, int threads = 1) {
  UniformSampler source(static_cast<int>(points.rows()), Model::kMinimalSize, rng.Fork("minimal_sets"));
  return SampleConsensus<Model>(points, threshold, source, options, rng, priors, threads);
}

/// The loop over every set, as far as the budget goes.
template <MinimalModel Model>
ConsensusResult SearchExhaustively(const PointMatrix& points, double threshold, const ConsensusOptions& options,
                                   const Rng& rng, const EstimationPriors& priors = {}, int threads = 1) {
  ExhaustiveSampler source(static_cast<int>(points.rows()), Model::kMinimalSize);
  return SampleConsensus<Model>(points, threshold, source, options, rng, priors, threads);
}

/// The loop over given sets, all of them unless the search is confident before.
template <MinimalModel Model>
ConsensusResult SearchSets(const PointMatrix& points, double threshold, std::span<const int> sets,
                           ConsensusOptions options, const Rng& rng, const EstimationPriors& priors = {},
                           int threads = 1) {
  PrecomputedSampler source(sets);
  options.max_iterations = std::max(1, static_cast<int>(sets.size()) / Model::kMinimalSize);
  return SampleConsensus<Model>(points, threshold, source, options, rng, priors, threads);
}

}  // namespace diffsac::testing
