#pragma once

#include "diffsac/consensus/local/local_optimization.h"
#include "diffsac/consensus/model_hooks.h"
#include "diffsac/consensus/scores/noise_scales.h"

namespace diffsac {

/// Asks the model's hook about degenerate hypotheses (model_hooks.h). Borrows scorer, score and scales.
template <MinimalModel Model>
class DegeneracyRecovery {
 public:
  DegeneracyRecovery(const Scorer<Model>& scorer, const Score& score, const NoiseScales& scales, const Rng& rng)
      : scorer_(scorer), score_(score), scales_(scales), rng_(rng) {}

  /// The best of `found` and what the hook offers in its place. set: what it was solved from; null: something else.
  ScoredModel<Model> operator()(const ScoredModel<Model>& found, [[maybe_unused]] const int* set,
                                [[maybe_unused]] int* fits) {
    ScoredModel<Model> best = found;
    if constexpr (HasDegeneracyRecovery<Model>) {
      typename Model::Parameters others[Model::kMaxSolutions];
      const double threshold = scales_.ThresholdFor(scorer_, found.model, scales_.score_threshold);
      const int count = ModelHooks<Model>::RecoverFromDegeneracy(scorer_.points(), set, found.model, threshold,
                                                                 rng_.Fork("degeneracy", runs_++), others, fits);
      for (int i = 0; i < count; ++i) {
        const ScoredModel<Model> other{others[i], scorer_(others[i], score_, best.score)};
        if (other.score > best.score) best = other;
      }
    }
    return best;
  }

 private:
  const Scorer<Model>& scorer_;
  const Score& score_;
  const NoiseScales& scales_;
  Rng rng_;
  std::uint64_t runs_ = 0;
};

}  // namespace diffsac
