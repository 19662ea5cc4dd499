#pragma once

#include "diffsac/consensus/degeneracy_recovery.h"
#include "diffsac/consensus/local_optimizer.h"

namespace diffsac {

/// What is made of each new best hypothesis inside the loop: it is mended where it is degenerate, and optimised
/// locally. Borrows scorer, score, options and scales.
template <MinimalModel Model>
class Improvement {
 public:
  Improvement(const Scorer<Model>& scorer, const Score& score, const ConsensusOptions& options,
              const NoiseScales& scales, const Rng& rng)
      : recover_(scorer, score, scales, rng), optimize_(scorer, score, options, scales, rng) {}

  /// The best model met, `found` itself when none scores higher. set: what it was solved from; null when it was given.
  /// Adds what was solved and fitted to *fits.
  ScoredModel<Model> operator()(const ScoredModel<Model>& found, const int* set, int* fits) {
    ScoredModel<Model> best = optimize_(set != nullptr ? recover_(found, set, fits) : found, fits);
    // Optimisation gathers points until a model is as degenerate as they are, so it is asked about once more.
    if (optimize_.active() || set == nullptr) {
      const ScoredModel<Model> mended = recover_(best, nullptr, fits);
      if (mended.score > best.score) best = optimize_(mended, fits);
    }
    return best;
  }

 private:
  DegeneracyRecovery<Model> recover_;
  LocalOptimizer<Model> optimize_;
};

}  // namespace diffsac
