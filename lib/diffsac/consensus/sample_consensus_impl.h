#pragma once

// The loop behind sample_consensus.h, for the files that instantiate it for a model.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "diffsac/consensus/local/final_refiner.h"
#include "diffsac/consensus/local/local_optimizer.h"
#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/scores/hypothesis_block.h"

namespace diffsac {

/// What scores take into account of the priors. Priors that are not one number a point say nothing; what is no
/// probability counts as the nearest one, and what is no number as 0.
inline ScorePrior PriorOf(const EstimationPriors& priors, const ConsensusOptions& options, Eigen::Index num_points) {
  ScorePrior prior{{}, priors.cameras};
  if (options.inlier_prior_power > 0.0 && priors.inlier_priors.size() == num_points) {
    const Eigen::ArrayXd probabilities = priors.inlier_priors.unaryExpr(
        [](double value) { return std::isnan(value) ? 0.0 : std::clamp(value, 0.0, 1.0); });
    prior.weights = probabilities.pow(options.inlier_prior_power);
  }
  return prior;
}

/// One search over one point set.
///
/// A block of sets is drawn from the sampler, solved and scored by all threads; then its draws are taken in order, and
/// everything that depends on earlier draws (the best, local optimisation, the stopping rule) happens there. Draws
/// behind the stop are thrown away. So neither threads nor blocks can change anything.
template <MinimalModel Model>
class ConsensusSearch {
 public:
  using Parameters = typename Model::Parameters;

  /// Borrows points and options.
  ConsensusSearch(const PointMatrix& points, const NoiseScales& scales, const ConsensusOptions& options,
                  const EstimationPriors& priors, const Rng& rng, int threads)
      : scales_(scales),
        scorer_(points, PriorOf(priors, options, points.rows())),
        score_(scales.MakeScore(options.score, options.inlier_prior)),
        best_(points, scales.score_threshold, std::max(1, options.refit_candidates)),
        improve_(scorer_, score_, options, scales_, rng),
        refine_(scorer_, options, scales_),
        rule_(options.stopping, options.max_iterations, options.min_iterations, options.confidence, points.rows(),
              Model::kMinimalSize),
        block_(scorer_, score_, options.block_size, threads) {}

  void Consider(const EstimationPriors& priors) {
    for (const ModelParameters& hint : priors.models)
      if (hint.size() == Parameters::SizeAtCompileTime && hint.allFinite()) Consider(Parameters(hint));
    if (priors.fit_weights.size() == 0) return;
    Parameters model;
    ++result_.hypotheses;
    if (Model::Fit(scorer_.points(), priors.fit_weights, &model)) Consider(model);
  }

  void Draw(MinimalSampler& sampler) {
    for (result_.stop = rule_.After(0); result_.stop == StopReason::kNotRun;) {
      const bool more = block_.Fill(sampler, rule_.max_iterations() - result_.iterations);
      while (result_.stop == StopReason::kNotRun) {
        const auto* draw = block_.Next(std::min(best_.bar(), best_minimal_));
        if (draw == nullptr) break;
        Take(*draw);
        result_.stop = rule_.After(result_.iterations);
      }
      if (result_.stop == StopReason::kNotRun && !more) result_.stop = StopReason::kExhausted;
    }
  }

  ConsensusResult Finish() {
    std::optional<ScoredModel<Model>> chosen = refine_(best_.entries(), &result_.hypotheses);
    result_.unique_minimal_sets = CountUniqueSets(sets_, Model::kMinimalSize);
    result_.first_sets = FirstSets(sets_, Model::kMinimalSize);
    if (!chosen || refine_.CountInliers(chosen->model) < Model::kMinimalSize) return std::move(result_);
    if constexpr (HasFocalPosterior<Model>) result_.focal = refine_.Marginalise(&*chosen, &result_.hypotheses);
    if constexpr (HasOtherMinimum<Model>) result_.other = refine_.OtherMinimum(&*chosen, &result_.hypotheses);
    result_.status = Status::kOk;
    result_.model = chosen->model;
    result_.score = chosen->score;
    const double threshold = refine_.MaskThreshold(chosen->model);
    result_.inlier_threshold = threshold;
    result_.noise_scale = refine_.NoiseScaleOf(chosen->model);
    result_.fit = refine_.FitOf(chosen->model);
    result_.inliers = InlierMask<Model>(scorer_.points(), chosen->model, threshold);
    return std::move(result_);
  }

 private:
  void Take(const typename HypothesisBlock<Model>::Draw& draw) {
    sets_.insert(sets_.end(), draw.set, draw.set + Model::kMinimalSize);
    ++result_.iterations;
    result_.hypotheses += std::max(1, draw.solutions);
    const double before = best_.best();
    int rise = -1;
    for (int i = 0; i < draw.solutions; ++i) {
      best_.Offer(draw.models[i], draw.scores[i]);
      if (!(draw.scores[i] > best_minimal_)) continue;
      best_minimal_ = draw.scores[i];
      rise = i;
    }
    if (rise >= 0) Improve({draw.models[rise], draw.scores[rise]}, draw.set, before);
  }

  /// A model that was given, not drawn: it may be as good as an improved one, and bars no minimal model's way.
  void Consider(const Parameters& model) {
    const double before = best_.best();
    const ScoredModel<Model> given{model, scorer_(model, score_, best_.bar())};
    best_.Offer(given.model, given.score);
    if (given.score > before) Improve(given, nullptr, before);
  }

  /// set: what the model was solved from; null when it was given. before: the best score before it.
  void Improve(const ScoredModel<Model>& found, const int* set, double before) {
    const ScoredModel<Model> improved = improve_(found, set, before, &result_.hypotheses);
    best_.Offer(improved.model, improved.score);
    if (best_.best() > before) rule_.Update(refine_.CountInliers(best_.entries().front().model));
  }

  const NoiseScales scales_;
  const Scorer<Model> scorer_;
  const Score score_;
  BestHypotheses<Model> best_;
  LocalOptimizer<Model> improve_;
  FinalRefiner<Model> refine_;
  StoppingRule rule_;
  HypothesisBlock<Model> block_;
  /// The best score of a draw before it is improved, what the next draw to be improved must exceed. Were it the best
  /// score of all, an improved model's, hardly any draw after the first improvement would do (PoseLib,
  /// robust/ransac_impl.h, keeps the two apart).
  double best_minimal_ = -1.0;
  std::vector<int> sets_;   ///< Those that were taken.
  ConsensusResult result_;  ///< What is known of it so far.
};

template <MinimalModel Model>
ConsensusResult SearchCheckedPoints(const PointMatrix& points, double inlier_threshold, MinimalSampler& sampler,
                                    const ConsensusOptions& options, const Rng& rng, const EstimationPriors& priors,
                                    int threads) {
  const NoiseScales scales = ScalesOf<Model>(points, inlier_threshold, options, priors.unit);
  if (!scales.Usable()) return {};
  ConsensusSearch<Model> search(points, scales, options, priors, rng, threads);
  search.Consider(priors);
  search.Draw(sampler);
  return search.Finish();
}

}  // namespace diffsac
