#pragma once

#include <optional>

#include "diffsac/consensus/local/degeneracy_recovery.h"
#include "diffsac/consensus/local/graph_cut_optimization.h"
#include "diffsac/consensus/local/irls.h"
#include "diffsac/consensus/local/local_optimization.h"
#include "diffsac/consensus/scores/noise_scales.h"

namespace diffsac {

/// What the model's own nonlinear refinement makes of `start`, added to *fits; `start` where there is none. The loss is
/// truncated, or where the model has that and the scorer, the loss or the number of steps asks for it, any loss with
/// the scorer's weights. steps: of Levenberg-Marquardt at most, where the model can be told.
template <MinimalModel Model>
typename Model::Parameters RefinedNonlinearly(const Scorer<Model>& scorer, const RobustLoss& loss,
                                              const typename Model::Parameters& start, [[maybe_unused]] int* fits,
                                              [[maybe_unused]] int steps = kMostRefineSteps) {
  typename Model::Parameters model = start;
  const auto keep = [&](bool refined) { return refined && model.allFinite() ? model : start; };
  if constexpr (HasFocalPosterior<Model>) {
    if (const auto& cameras = scorer.prior().cameras) {
      ++*fits;
      return keep(
          ModelHooks<Model>::Refine(scorer.points(), scorer.AllWeights(), loss, cameras->focal(), &model, steps));
    }
  }
  if constexpr (HasRobustRefine<Model>) {
    const bool weighted = scorer.weights().size() > 0;
    if (weighted || loss.kind != LossKind::kTruncated || steps < kMostRefineSteps) {
      ++*fits;
      if constexpr (HasLimitedRefine<Model>)
        return keep(ModelHooks<Model>::Refine(scorer.points(), scorer.AllWeights(), loss, &model, steps));
      else
        return keep(ModelHooks<Model>::Refine(scorer.points(), scorer.AllWeights(), loss, &model));
    }
  }
  if constexpr (HasRefine<Model>) {
    ++*fits;
    return keep(ModelHooks<Model>::Refine(scorer.points(), loss.scale, &model));
  }
  return start;
}

/// What is made of each new best minimal model inside the loop: it is mended where it is degenerate, and optimised in
/// the way that options.local_optimization says. Borrows scorer, score, options and scales.
template <MinimalModel Model>
class LocalOptimizer {
 public:
  LocalOptimizer(const Scorer<Model>& scorer, const Score& score, const ConsensusOptions& options,
                 const NoiseScales& scales, const Rng& rng)
      : scorer_(scorer),
        score_(score),
        options_(options),
        scales_(scales),
        rng_(rng),
        recover_(scorer, score, scales, rng) {}

  /// The best model met, `found` itself when none scores higher. set: what it was solved from; null when it was given.
  /// best_score: of all models before it; one that scores no more is not asked about degeneracy, which would cost more
  /// than its optimisation. Adds what was solved and fitted to *fits.
  ScoredModel<Model> operator()(const ScoredModel<Model>& found, const int* set, double best_score, int* fits) {
    const bool ask = set != nullptr && found.score > best_score;
    ScoredModel<Model> best = Optimize(ask ? recover_(found, set, fits) : found, fits);
    // Optimisation gathers points until a model is as degenerate as they are, so it is asked about once more.
    if (best.score > best_score && (active() || set == nullptr)) {
      const ScoredModel<Model> mended = recover_(best, nullptr, fits);
      if (mended.score > best.score) best = Optimize(mended, fits);
    }
    return best;
  }

 private:
  bool active() const { return options_.local_optimization != LocalOptimization::kNone; }

  /// The best model met, `start` itself when none scores higher. Fits are added to *fits.
  ScoredModel<Model> Optimize(const ScoredModel<Model>& start, int* fits) {
    if (!active()) return start;
    const double threshold = scales_.ThresholdFor(scorer_, start.model, scales_.score_threshold);
    const Rng rng = rng_.Fork("local_optimization", runs_++);
    switch (options_.local_optimization) {
      case LocalOptimization::kInnerSamples:
        return OptimizeByInnerSamples<Model>(scorer_, score_, threshold, options_.local_samples, start, rng, fits);
      case LocalOptimization::kReweighted:
        return OptimizeReweighted<Model>(scorer_, score_, MagsacLoss(threshold, scales_.residual_dof),
                                         options_.irls_rounds, start, fits);
      case LocalOptimization::kGraphCut:
        if (!graph_cut_) graph_cut_.emplace(scorer_.points(), options_.graph_neighbors, options_.spatial_weight);
        return OptimizeByGraphCut<Model>(scorer_, score_, threshold, *graph_cut_, options_.local_samples, start, rng,
                                         fits);
      case LocalOptimization::kRefinement: {
        const auto model = RefinedNonlinearly<Model>(scorer_, {LossKind::kTruncated, threshold}, start.model, fits);
        const double score = scorer_(model, score_, start.score);
        return score > start.score ? ScoredModel<Model>{model, score} : start;
      }
      case LocalOptimization::kNone:
        break;
    }
    return start;
  }

  const Scorer<Model>& scorer_;
  const Score& score_;
  const ConsensusOptions& options_;
  const NoiseScales& scales_;
  Rng rng_;
  DegeneracyRecovery<Model> recover_;
  std::optional<GraphCut> graph_cut_;  ///< Made when it is first needed.
  std::uint64_t runs_ = 0;
};

}  // namespace diffsac
