#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/ransac/local/graph_cut.h"
#include "diffsac/ransac/local/inner_samples.h"
#include "diffsac/ransac/model_hooks.h"
#include "diffsac/ransac/policies.h"
#include "diffsac/ransac/scores/magsac_loss.h"
#include "diffsac/ransac/scores/noise_scales.h"
#include "diffsac/ransac/scores/scorer.h"

namespace diffsac {

/// Iteratively reweighted least squares with the weights of MAGSAC++ (σ-consensus++: Barath, Noskova, Ivashechkin,
/// Matas, CVPR 2020, section 3.2), until no weight moves by more than 1e-3 of the largest, `rounds` times at most.
/// Returns the best model met by `score`, the start itself when none scores higher; every fit is added to *fits.
template <MinimalModel Model>
ScoredModel<Model> OptimizeReweighted(const Scorer<Model>& scorer, const Score& score, const MagsacLoss& loss,
                                      int rounds, const ScoredModel<Model>& start, int* fits) {
  constexpr double kTolerance = 1e-3;
  ScoredModel<Model> best = start;
  typename Model::Parameters model = start.model;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(scorer.size());
  for (int round = 0; round < rounds; ++round) {
    Eigen::VectorXd next = scorer.Residuals(model).unaryExpr([&](double r) { return loss.Weight(r); });
    const double largest = next.maxCoeff();
    if (!(largest > 0.0)) break;
    next /= largest;
    if (round > 0 && (next - weights).cwiseAbs().maxCoeff() <= kTolerance) break;
    weights = next;
    ++*fits;
    if (!FitAgain(scorer, weights, &model)) break;
    const double value = scorer(model, score, best.score);
    if (value > best.score) best = {model, value};
  }
  return best;
}

/// Local optimisation of graph-cut RANSAC (Barath and Matas, CVPR 2018, algorithm 2): the best model's inliers are
/// found by a graph cut, then least squares on all of them and, `samples` times, on 7γ random ones; from the start
/// again while the score rises, kRounds times at most. Returns the best model met, the start itself when none scores
/// higher; every fit is added to *fits.
template <MinimalModel Model>
ScoredModel<Model> OptimizeByGraphCut(const Scorer<Model>& scorer, const Score& score, double threshold,
                                      const GraphCut& graph_cut, int samples, const ScoredModel<Model>& start, Rng rng,
                                      int* fits) {
  constexpr int kRounds = 10;
  ScoredModel<Model> best = start;
  std::vector<int> inliers, chosen;
  const auto fit = [&](const Eigen::VectorXd& weights) {
    typename Model::Parameters model = best.model;
    ++*fits;
    if (!FitAgain(scorer, weights, &model)) return;
    const double value = scorer(model, score, best.score);
    if (value > best.score) best = {model, value};
  };
  for (int round = 0; round < kRounds; ++round) {
    const double before = best.score;
    const std::vector<std::uint8_t> labels = graph_cut.Label(scorer.Residuals(best.model), threshold);
    inliers.clear();
    for (int i = 0; i < scorer.size(); ++i)
      if (labels[i]) inliers.push_back(i);
    const int available = static_cast<int>(inliers.size());
    if (available < Model::kMinimalSize) break;
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(scorer.size());
    for (int i : inliers) weights[i] = 1.0;
    fit(weights);
    const int size = std::min(7 * Model::kMinimalSize, available);
    chosen.resize(size);
    for (int sample = 0; sample < samples && size < available; ++sample) {
      rng.Distinct(available, size, chosen.data());
      weights.setZero();
      for (int position : chosen) weights[inliers[position]] = 1.0;
      fit(weights);
    }
    if (!(best.score > before)) break;
  }
  return best;
}

/// What the model's own nonlinear refinement makes of `start`, added to *fits; `start` where there is none. loss: with
/// the scorer's weights, where the model has that, else truncated at its scale. steps: of Levenberg-Marquardt at most,
/// where the model can be told.
template <MinimalModel Model>
typename Model::Parameters RefinedNonlinearly(const Scorer<Model>& scorer, [[maybe_unused]] const RobustLoss& loss,
                                              const typename Model::Parameters& start, [[maybe_unused]] int* fits,
                                              [[maybe_unused]] int steps = kMostRefineSteps) {
  if constexpr (!HasRefine<Model>) {
    return start;
  } else {
    typename Model::Parameters model = start;
    const auto refine = [&] {
      if constexpr (HasFocalPosterior<Model>)
        if (const auto& cameras = scorer.prior().cameras)
          return Model::Refine(scorer.points(), scorer.WeightsUnder(start), loss, cameras->focals(), &model, steps);
      if constexpr (HasRobustRefine<Model>)
        return Model::Refine(scorer.points(), scorer.WeightsUnder(start), loss, &model, steps);
      else
        return Model::Refine(scorer.points(), loss.scale, &model);
    };
    ++*fits;
    return refine() && model.allFinite() ? model : start;
  }
}

/// What is made of each new best minimal model inside the loop: it is mended where it is degenerate, and optimised in
/// the way that options.local_optimization says. Borrows scorer, score, options and scales.
template <MinimalModel Model>
class LocalOptimizer {
 public:
  LocalOptimizer(const Scorer<Model>& scorer, const Score& score, const ConsensusOptions& options,
                 const NoiseScales& scales, const Rng& rng)
      : scorer_(scorer), score_(score), options_(options), scales_(scales), rng_(rng) {}

  /// The best model met, `found` itself when none scores higher. set: what it was solved from; null when it was given.
  /// best_score: of all models before it; one that scores no more is not asked about degeneracy, which would cost more
  /// than its optimisation. Adds what was solved and fitted to *fits.
  ScoredModel<Model> operator()(const ScoredModel<Model>& found, const int* set, double best_score, int* fits) {
    const bool ask = set != nullptr && found.score > best_score;
    ScoredModel<Model> best = Optimize(ask ? Recovered(found, set, fits) : found, fits);
    // Optimisation gathers points until a model is as degenerate as they are, so it is asked about once more.
    if (best.score > best_score && (active() || set == nullptr)) {
      const ScoredModel<Model> mended = Recovered(best, nullptr, fits);
      if (mended.score > best.score) best = Optimize(mended, fits);
    }
    return best;
  }

  /// The best model met on another way from `model`, which may score less.
  ScoredModel<Model> Again(const typename Model::Parameters& model, int* fits) { return Optimize({model, -1.0}, fits); }

 private:
  bool active() const { return options_.local_optimization != LocalOptimization::kNone; }

  /// The best of `found` and what the model's hook offers in its place where that is degenerate (model_hooks.h).
  ScoredModel<Model> Recovered(const ScoredModel<Model>& found, [[maybe_unused]] const int* set,
                               [[maybe_unused]] int* fits) {
    ScoredModel<Model> best = found;
    if constexpr (HasDegeneracyRecovery<Model>) {
      typename Model::Parameters others[Model::kMaxSolutions];
      const double threshold = scales_.ThresholdFor(scorer_, found.model, scales_.score_threshold);
      const int count = Model::RecoverFromDegeneracy(scorer_.points(), set, found.model, threshold,
                                                     rng_.Fork("degeneracy", recoveries_++), others, fits);
      for (int i = 0; i < count; ++i) {
        const ScoredModel<Model> other{others[i], scorer_(others[i], score_, best.score)};
        if (other.score > best.score) best = other;
      }
    }
    return best;
  }

  /// The best model met, `start` itself when none scores higher. Fits are added to *fits.
  ScoredModel<Model> Optimize(const ScoredModel<Model>& start, [[maybe_unused]] int* fits) {
    if constexpr (!NeverFits<Model>) {
      if (!active()) return start;
      const double threshold = scales_.ThresholdFor(scorer_, start.model, scales_.score_threshold);
      const Rng rng = rng_.Fork("local_optimization", runs_++);
      if (options_.local_optimization == LocalOptimization::kInnerSamples)
        return OptimizeByInnerSamples<Model>(scorer_, score_, threshold, options_.local_samples, start, rng, fits);
      if constexpr (!HasUsualPolicies<Model>) return OptimizeOtherwise(start, threshold, rng, fits);
    }
    return start;
  }

  ScoredModel<Model> OptimizeOtherwise(const ScoredModel<Model>& start, double threshold, const Rng& rng, int* fits) {
    switch (options_.local_optimization) {
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
      case LocalOptimization::kInnerSamples:
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
  std::optional<GraphCut> graph_cut_;  ///< Made when it is first needed.
  std::uint64_t runs_ = 0, recoveries_ = 0;
};

}  // namespace diffsac
