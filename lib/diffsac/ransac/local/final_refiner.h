#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "diffsac/geometry/noise_of_inliers.h"
#include "diffsac/ransac/consensus_result.h"
#include "diffsac/ransac/local/local_optimizer.h"

namespace diffsac {

/// What happens after the search: the best hypotheses are refitted and refined, and the best result by
/// options.final_score is chosen. Those that are refitted to the same model are refined once. With
/// options.num_finalists, all are refitted once and refined by a few steps, and only the best of them to the end.
/// Borrows scorer and options.
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
  template <class Entries>
  std::optional<ScoredModel<Model>> operator()(const Entries& hypotheses, int* fits) const {
    const bool staged = InStages(hypotheses.size());
    std::vector<Parameters> refitted;
    std::vector<ScoredModel<Model>> candidates;
    for (const auto& hypothesis : hypotheses) {
      const ScoredModel<Model> start = Refitted(hypothesis.model, staged ? 1 : options_.refit_rounds, fits);
      if (std::find(refitted.begin(), refitted.end(), start.model) != refitted.end()) continue;
      refitted.push_back(start.model);
      candidates.push_back(Refined(start, staged ? kFirstSteps : kMostRefineSteps, fits));
    }
    if (staged) Finish(&candidates, fits);
    const auto best = std::max_element(candidates.begin(), candidates.end(),
                                       [](const auto& a, const auto& b) { return a.score < b.score; });
    if (best == candidates.end()) return std::nullopt;
    if constexpr (!HasUsualPolicies<Model>)
      if (options_.refit == Refit::kMixture && options_.sigma_prior > 0.0) return WithSigmaEstimated(*best, fits);
    return *best;
  }

  /// Says in *result what is to be said of the chosen model, of these hypotheses; nothing where fewer than γ points
  /// support it.
  template <class Entries>
  void Complete(const Entries& hypotheses, ScoredModel<Model> chosen, ConsensusResult* result) const {
    if (CountInliers(chosen.model) < Model::kMinimalSize) return;
    if constexpr (HasFocalPosterior<Model>) result->focal = Marginalise(&chosen, &result->hypotheses);
    if constexpr (HasOtherMinimum<Model>) result->other = OtherMinimum(&chosen, &result->hypotheses);
    if constexpr (HasRivals<Model>) FindRival(hypotheses, chosen, result);
    Report(chosen, result);
  }

  /// A mask of the points that support the model.
  std::vector<std::uint8_t> Inliers(const Parameters& model) const {
    const Eigen::VectorXd residuals = scorer_.Residuals(model);
    return MaskOf(residuals, scales_.SupportThreshold(residuals));
  }

 private:
  /// The posterior of the chosen model's focal lengths, and the model at its median in place of *chosen, whose score
  /// may fall: it is the prior's share. Nothing without a prior, or where the points do not determine the model.
  std::optional<FocalPosteriors> Marginalise(ScoredModel<Model>* chosen, int* fits) const {
    FocalPosteriors posterior;
    const std::optional<CameraPrior>& cameras = scorer_.prior().cameras;
    if (!cameras) return std::nullopt;
    Parameters model = chosen->model;
    ++*fits;
    if (!Model::Marginalise(scorer_.points(), scorer_.WeightsUnder(model), LossAt(model), cameras->focals(), &model,
                            &posterior) ||
        CountInliers(model) < Model::kMinimalSize)
      return std::nullopt;
    *chosen = {model, ScoreOf(model)};
    return posterior;
  }

  /// Puts the better of its two minima in *chosen; the other one where the points do not tell them apart.
  std::optional<ModelParameters> OtherMinimum(ScoredModel<Model>* chosen, int* fits) const {
    if (options_.final_refinement == FinalRefinement::kNone) return std::nullopt;
    Parameters model = chosen->model, other;
    const bool as_good = Model::OtherMinimum(scorer_.points(), LossAt(model).scale, &model, &other, fits);
    if (model != chosen->model) *chosen = {model, ScoreOf(model)};
    return as_good ? std::optional<ModelParameters>(other) : std::nullopt;
  }

  /// Puts another model into *result that may be the right one as well: of the points that only one of the two
  /// explains, it has no fewer than chance would give it in one case of twenty if they fell to either alike.
  template <class Entries>
  void FindRival(const Entries& hypotheses, const ScoredModel<Model>& chosen, ConsensusResult* result) const {
    constexpr double kSigmas = 1.645;
    const auto fitting = [&](const Parameters& model) -> Eigen::ArrayXd {
      const Eigen::VectorXd residuals = scorer_.Residuals(model);
      return (residuals.array() <= scales_.SupportThreshold(residuals)).template cast<double>();
    };
    const Eigen::ArrayXd own = fitting(chosen.model);
    const auto rivals = [&](const Eigen::ArrayXd& other, double slack) {
      const double first = (own * (1.0 - other)).sum(), second = (other * (1.0 - own)).sum();
      return second > Model::kMinimalSize && first - slack * second <= kSigmas * std::sqrt(first + second);
    };
    for (const auto& hypothesis : hypotheses) {
      // Not yet refined it may have half of them.
      if (!rivals(fitting(hypothesis.model), 2.0)) continue;
      const Parameters model = Refitted(hypothesis.model, options_.refit_rounds, &result->hypotheses).model;
      const Eigen::ArrayXd other = fitting(model);
      const int alone = static_cast<int>((other * (1.0 - own)).sum());
      // One that shares most of its points is no other one.
      if (!rivals(other, 1.0) || alone <= (other * own).sum() || alone <= result->other_inliers) continue;
      result->other = model;
      result->other_inliers = alone;
    }
  }

  /// Says of the chosen model, *result, all that its residuals tell.
  void Report(const ScoredModel<Model>& chosen, ConsensusResult* result) const {
    constexpr int kDimension = ResidualDimension<Model>();
    const Eigen::VectorXd residuals = scorer_.Residuals(chosen.model);
    const double support = scales_.SupportThreshold(residuals), threshold = std::min(scales_.threshold, support);
    result->status = Status::kOk;
    result->model = chosen.model;
    result->score = chosen.score;
    result->inlier_threshold = threshold;
    result->sigma = NoiseOfInliers(residuals, kDimension, FreeParameters<Model>(), support);
    result->inliers = MaskOf(residuals, threshold);
    if (!HasRefine<Model> || options_.final_refinement == FinalRefinement::kNone) return;
    result->fit = {LossAt(chosen.model), support};
    if constexpr (HasRobustRefine<Model>)
      if (scorer_.Weighs()) result->fit->weights = scorer_.WeightsUnder(chosen.model);
  }

  /// The points that support the model.
  int CountInliers(const Parameters& model) const {
    const Eigen::VectorXd residuals = scorer_.Residuals(model);
    return static_cast<int>((residuals.array() <= scales_.SupportThreshold(residuals)).count());
  }

  static std::vector<std::uint8_t> MaskOf(const Eigen::VectorXd& residuals, double threshold) {
    std::vector<std::uint8_t> mask(residuals.size());
    for (Eigen::Index i = 0; i < residuals.size(); ++i) mask[i] = residuals[i] <= threshold;
    return mask;
  }

  /// Steps of nonlinear refinement before the finalists are chosen.
  static constexpr int kFirstSteps = 2;

  /// A model and what its residuals say, which are worked out once.
  struct Evaluation {
    Eigen::VectorXd residuals;
    double threshold;  ///< Of what supports it.
    double score;
    int inliers;
  };

  Evaluation Evaluate(const Parameters& model) const {
    Evaluation result{scorer_.Residuals(model), 0.0, 0.0, 0};
    result.threshold = scales_.SupportThreshold(result.residuals);
    result.inliers = static_cast<int>((result.residuals.array() <= result.threshold).count());
    result.score = score_.kind() == ScoreKind::kMlesac ? MixtureScore(scales_.mixture, result.residuals)
                                                       : scorer_(model, result.residuals, score_);
    return result;
  }

  bool InStages(std::size_t candidates) const {
    return options_.num_finalists > 0 && options_.final_refinement != FinalRefinement::kNone &&
           candidates > static_cast<std::size_t>(options_.num_finalists);
  }

  /// Leaves the best candidates, refined to the end.
  void Finish(std::vector<ScoredModel<Model>>* candidates, int* fits) const {
    std::stable_sort(candidates->begin(), candidates->end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
    const auto most = static_cast<std::size_t>(options_.num_finalists);
    if (candidates->size() > most) candidates->erase(candidates->begin() + most, candidates->end());
    for (auto& candidate : *candidates) candidate = Refined(candidate, kMostRefineSteps, fits);
  }

  double ScoreOf(const Parameters& model) const {
    if (score_.kind() == ScoreKind::kMlesac) return Likelihood(model);
    return scorer_(model, score_);
  }

  double Likelihood(const Parameters& model) const { return MixtureScore(scales_.mixture, scorer_.Residuals(model)); }

  /// `fitted`, or `start` where fewer than γ points support it or `score`, a function of a model, is lower.
  template <class ScoreFunction>
  Parameters Better(const Parameters& start, const Parameters& fitted, const ScoreFunction& score) const {
    return CountInliers(fitted) >= Model::kMinimalSize && score(fitted) >= score(start) ? fitted : start;
  }

  /// threshold: of what supports the model.
  double RefitThreshold(double threshold) const {
    return scales_.noise ? options_.refit_threshold_factor * threshold : scales_.refit_threshold;
  }

  double InlierShare(const Parameters& model) const {
    return static_cast<double>(CountInliers(model)) / scorer_.size();
  }

  /// rounds: of kIterated. With its final score.
  ScoredModel<Model> Refitted(const Parameters& start, [[maybe_unused]] int rounds, [[maybe_unused]] int* fits) const {
    if constexpr (!NeverFits<Model>)
      if (options_.refit == Refit::kIterated) return Iterated(start, rounds, fits);
    Parameters model = start;
    if constexpr (!HasUsualPolicies<Model>) {
      if (options_.refit == Refit::kInliers) model = FittedToInliers(start, fits);
      if (options_.refit == Refit::kMixture) model = FittedToMixture(start, fits);
      if (options_.refit == Refit::kReweighted) model = Reweighted(start, fits);
    }
    return {model, ScoreOf(model)};
  }

  /// Kept by what least squares lowers, the squares truncated at its own threshold. A hypothesis that was chosen for
  /// its inlier count, or for a wider score, is the luckiest of many by that one: by it the more accurate model would
  /// lose.
  Parameters FittedToInliers(const Parameters& start, int* fits) const {
    const double threshold = RefitThreshold(scales_.ThresholdFor(scorer_, start, scales_.threshold));
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

  ScoredModel<Model> Iterated(const Parameters& start, int rounds, int* fits) const {
    Parameters model = start;
    const Evaluation first = Evaluate(start);
    Evaluation best = first;
    Eigen::VectorXd weights(scorer_.size());
    for (int round = 0; round < rounds; ++round) {
      Parameters next = model;
      ++*fits;
      weights = (best.residuals.array() <= RefitThreshold(best.threshold)).template cast<double>();
      if (!FitAgain<Model>(scorer_.points(), weights, &next)) break;
      Evaluation found = Evaluate(next);
      if (!(found.score >= best.score)) break;
      const bool settled = next == model;
      model = next;
      best = std::move(found);
      if (settled) break;
    }
    if (best.inliers < Model::kMinimalSize) return {start, first.score};
    return {model, best.score};
  }

  /// By the final score where that is a sum over points; the mixture's own is compared once, at the end.
  Parameters Reweighted(const Parameters& start, int* fits) const {
    const MagsacLoss loss(scales_.reweight_threshold, scales_.residual_dof);
    const ScoredModel<Model> found{start, scorer_(start, score_)};
    const Parameters model = OptimizeReweighted<Model>(scorer_, score_, loss, options_.irls_rounds, found, fits).model;
    return Better(start, model, [&](const Parameters& m) { return ScoreOf(m); });
  }

  ScoredModel<Model> Refined(const ScoredModel<Model>& start, int steps, int* fits) const {
    if (options_.final_refinement == FinalRefinement::kNone) return start;
    const Parameters model = RefinedNonlinearly<Model>(scorer_, LossAt(start.model), start.model, fits, steps);
    if (model == start.model) return start;
    const Evaluation found = Evaluate(model);
    const bool keep = found.inliers >= Model::kMinimalSize && found.score >= start.score;
    return keep ? ScoredModel<Model>{model, found.score} : start;
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
