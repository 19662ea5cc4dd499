#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "diffsac/consensus/best_hypotheses.h"
#include "diffsac/consensus/local_optimizer.h"
#include "diffsac/geometry/fit_conditions.h"

namespace diffsac {

/// What happens after the search: the best hypotheses are refitted and refined, and the best result by
/// options.final_score is chosen. Those that are refitted to the same model are refined once. Borrows scorer
/// and options.
template <MinimalModel Model>
class FinalRefiner {
 public:
  using Parameters = typename Model::Parameters;

  FinalRefiner(const Scorer<Model>& scorer, const ConsensusOptions& options, const NoiseScales& scales)
      : scorer_(scorer),
        options_(options),
        scales_(scales),
        score_(scales.MakeScore(options.final_score, options.inlier_prior)) {}

  /// The chosen model with its final score, of hypotheses best first; nothing without any. Fits are added to *fits.
  std::optional<ScoredModel<Model>> operator()(const std::vector<typename BestHypotheses<Model>::Entry>& hypotheses,
                                               int* fits) const {
    std::optional<ScoredModel<Model>> best;
    std::vector<Parameters> refined;
    for (const auto& hypothesis : hypotheses) {
      const Parameters refitted = Refitted(hypothesis.model, fits);
      if (std::find(refined.begin(), refined.end(), refitted) != refined.end()) continue;
      refined.push_back(refitted);
      const Parameters model = Refined(refitted, fits);
      const double score = ScoreOf(model);
      if (!best || score > best->score) best = {model, score};
    }
    if (best && options_.refit == Refit::kMixture && options_.sigma_prior > 0.0) best = WithSigmaEstimated(*best, fits);
    return best;
  }

  /// The posterior of the chosen model's focal length, and the model at its median in place of *chosen, whose score may
  /// fall: it is the prior's share. Nothing without a prior, or where the points do not determine the model.
  std::optional<FocalPosterior> Marginalise(ScoredModel<Model>* chosen, int* fits) const {
    const std::optional<CameraPrior>& cameras = scorer_.prior().cameras;
    FocalPosterior posterior;
    if (!cameras) return std::nullopt;
    Parameters model = chosen->model;
    ++*fits;
    if (!ModelHooks<Model>::Marginalise(scorer_.points(), scorer_.AllWeights(), LossAt(model), cameras->focal(), &model,
                                        &posterior) ||
        CountInliers(model) < Model::kMinimalSize)
      return std::nullopt;
    *chosen = {model, ScoreOf(model)};
    return posterior;
  }

  /// The points that support the model.
  int CountInliers(const Parameters& model) const {
    const Eigen::VectorXd residuals = scorer_.Residuals(model);
    return static_cast<int>((residuals.array() <= scales_.SupportThreshold(residuals)).count());
  }

  /// What an inlier of the model is: ε at most.
  double MaskThreshold(const Parameters& model) const {
    return std::min(scales_.threshold, scales_.ThresholdFor(scorer_, model, scales_.threshold));
  }

  /// σ of the residuals within `threshold` (ConsensusResult::noise_scale).
  double NoiseScaleOf(const Parameters& model, double threshold) const {
    const Eigen::VectorXd residuals = scorer_.Residuals(model);
    if (scales_.noise) return scales_.SupportThreshold(residuals) / kSigmasOfInlier;
    const auto inlier = residuals.array() <= threshold;
    const double spare = static_cast<double>(inlier.count()) - Model::kMinimalSize;
    if (!(spare > 0.0)) return std::numeric_limits<double>::quiet_NaN();
    return std::sqrt(inlier.select(residuals.array().square(), 0.0).sum() / spare);
  }

  /// What the model is a minimum of, with the threshold of what supports it; nothing where none was refined.
  std::optional<FitConditions> FitOf(const Parameters& model) const {
    if (!HasRefine<Model> || options_.final_refinement == FinalRefinement::kNone) return std::nullopt;
    FitConditions fit{LossAt(model), scales_.SupportThreshold(scorer_.Residuals(model))};
    if constexpr (HasRobustRefine<Model>) fit.weights = scorer_.weights();
    if constexpr (HasFocalPosterior<Model>)
      if (scorer_.prior().cameras) fit.focal = scorer_.prior().cameras->focal();
    return fit;
  }

 private:
  double ScoreOf(const Parameters& model) const {
    if (score_.kind() == ScoreKind::kGaussianUniform) return Likelihood(model);
    return scorer_(model, score_);
  }

  double Likelihood(const Parameters& model) const { return MixtureScore(scales_.mixture, scorer_.Residuals(model)); }

  /// `fitted`, or `start` where fewer than γ points support it or `score`, a function of a model, is lower.
  template <class ScoreFunction>
  Parameters Better(const Parameters& start, const Parameters& fitted, const ScoreFunction& score) const {
    return CountInliers(fitted) >= Model::kMinimalSize && score(fitted) >= score(start) ? fitted : start;
  }

  double RefitThreshold(const Parameters& model) const {
    if (!scales_.noise) return scales_.refit_threshold;
    return options_.refit_threshold_factor * scales_.ThresholdFor(scorer_, model, scales_.threshold);
  }

  double InlierShare(const Parameters& model) const {
    return static_cast<double>(CountInliers(model)) / scorer_.size();
  }

  Parameters Refitted(const Parameters& start, int* fits) const {
    switch (options_.refit) {
      case Refit::kInliers:
        return FittedToInliers(start, fits);
      case Refit::kIterated:
        return Iterated(start, fits);
      case Refit::kMixture:
        return FittedToMixture(start, fits);
      case Refit::kReweighted:
        return Reweighted(start, fits);
      case Refit::kNone:
        break;
    }
    return start;
  }

  /// Kept by what least squares lowers, the squares truncated at its own threshold. A hypothesis that was chosen for
  /// its inlier count, or for a wider score, is the luckiest of many by that one: by it the more accurate model would
  /// lose.
  Parameters FittedToInliers(const Parameters& start, int* fits) const {
    const double threshold = RefitThreshold(start);
    const Score squares(ScoreKind::kMsac, threshold, 0.0, 0.0);
    Parameters model = start;
    ++*fits;
    FitInliers(scorer_, threshold, &model);
    return Better(start, model, [&](const Parameters& m) { return scorer_(m, squares); });
  }

  Parameters FittedToMixture(const Parameters& start, int* fits) const {
    Parameters model = start;
    *fits += MixtureRefit<Model>(scorer_.points(), scales_.mixture, InlierShare(start), &model);
    return Better(start, model, [&](const Parameters& m) { return Likelihood(m); });
  }

  Parameters Iterated(const Parameters& start, int* fits) const {
    ScoredModel<Model> best{start, ScoreOf(start)};
    for (int round = 0; round < options_.refit_rounds; ++round) {
      Parameters next = best.model;
      ++*fits;
      if (!FitInliers(scorer_, RefitThreshold(next), &next)) break;
      const double score = ScoreOf(next);
      if (!(score >= best.score)) break;
      const bool settled = next == best.model;
      best = {next, score};
      if (settled) break;
    }
    return CountInliers(best.model) < Model::kMinimalSize ? start : best.model;
  }

  /// By the final score where that is a sum over points; the mixture's own is compared once, at the end.
  Parameters Reweighted(const Parameters& start, int* fits) const {
    const MagsacLoss loss(scales_.reweight_threshold, scales_.residual_dof);
    const ScoredModel<Model> found{start, scorer_(start, score_)};
    const Parameters model = OptimizeReweighted<Model>(scorer_, score_, loss, options_.irls_rounds, found, fits).model;
    return Better(start, model, [&](const Parameters& m) { return ScoreOf(m); });
  }

  Parameters Refined(const Parameters& start, int* fits) const {
    if (options_.final_refinement == FinalRefinement::kNone) return start;
    const Parameters model = RefinedNonlinearly<Model>(scorer_, LossAt(start), start, fits);
    return Better(start, model, [&](const Parameters& m) { return ScoreOf(m); });
  }

  RobustLoss LossAt(const Parameters& start) const {
    if (options_.final_refinement == FinalRefinement::kMarginalised)
      return {LossKind::kMarginalised, scales_.greatest, scales_.least};
    return {LossKind::kTruncated, scales_.ThresholdFor(scorer_, start, scales_.score_threshold)};
  }

  /// Once, for the model that won with σ assumed: candidates that each chose their own σ would not compare as well
  /// (docs/experiments.md).
  ScoredModel<Model> WithSigmaEstimated(const ScoredModel<Model>& chosen, int* fits) const {
    Parameters model = chosen.model;
    double sigma = 0.0;
    *fits += MixtureRefit<Model>(scorer_.points(), scales_.mixture, InlierShare(model), &model, options_.sigma_prior,
                                 &sigma);
    const Mixture estimated = scales_.mixture.WithSigma(sigma);
    const auto likelihood = [&](const Parameters& m) { return MixtureScore(estimated, scorer_.Residuals(m)); };
    const bool keep = CountInliers(model) >= Model::kMinimalSize && likelihood(model) >= likelihood(chosen.model);
    return keep ? ScoredModel<Model>{model, ScoreOf(model)} : chosen;
  }

  const Scorer<Model>& scorer_;
  const ConsensusOptions& options_;
  const NoiseScales& scales_;
  Score score_;
};

}  // namespace diffsac
