#pragma once

// The definitions behind sample_consensus.h, for the files that instantiate them for a model.

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/consensus/best_hypotheses.h"
#include "diffsac/consensus/consensus_kinds.h"
#include "diffsac/consensus/graph_cut_optimization.h"
#include "diffsac/consensus/irls.h"
#include "diffsac/consensus/local_optimization.h"
#include "diffsac/consensus/mixture.h"
#include "diffsac/consensus/model_hooks.h"
#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/scorer.h"
#include "diffsac/consensus/sprt.h"
#include "diffsac/core/parallel.h"

namespace diffsac {
namespace consensus_internal {

/// How many draws to make.
struct Stopping {
  std::int64_t max_iterations;
  std::int64_t min_iterations;
  bool by_confidence;
};

/// One run over one point set: what is fixed, and the hypotheses gathered so far.
///
/// A block of sets is drawn, solved and scored by all threads; then its draws are taken in order, and everything that
/// depends on earlier draws (the best, local optimisation, the stopping rule) happens there. Draws behind the stop are
/// thrown away. So neither threads nor blocks can change anything.
template <MinimalModel Model>
class Run {
 public:
  using Parameters = typename Model::Parameters;

  Run(const PointMatrix& points, double threshold, const ConsensusOptions& options, Rng rng)
      : options_(options),
        threshold_(threshold),
        score_threshold_(options.score_threshold_factor * threshold),
        residual_dof_(options.residual_dof > 0 ? options.residual_dof : ResidualDof<Model>()),
        mixture_(MakeMixture(points, threshold, options.sigma_factor * threshold)),
        local_(LocalOptimizationFromString(options.local_optimization)),
        refit_(RefitFromString(options.refit)),
        refine_at_end_(FinalRefinementFromString(options.final_refinement)),
        final_kind_(ScoreKindFromString(options.final_score)),
        rng_(rng),
        scorer_(points),
        score_(MakeScore(ScoreKindFromString(options.score))),
        final_(MakeScore(final_kind_)),
        best_(points, score_threshold_, std::max(1, options.refit_candidates)) {
    if (options.sprt) StartSequentialTest();
  }

  void ConsiderSource(const HypothesisSource& source, const Stopping& stopping, int threads) {
    threads = threads <= 0 ? HardwareThreads() : threads;
    const Rng sets_rng = rng_.Fork("minimal_sets");
    int block_size = options_.block_size > 0 ? options_.block_size : kFirstBlock;
    stop_ = StopReason::kNotRun;
    while (stop_ == StopReason::kNotRun) {
      const int count = static_cast<int>(std::min<std::int64_t>(block_size, stopping.max_iterations - iterations_));
      sets_.clear();
      const int given =
          count > 0 ? source.DrawBlock(scorer_.size(), Model::kMinimalSize, iterations_, count, sets_rng, &sets_) : 0;
      TakeBlock(given, stopping, threads);
      if (stop_ == StopReason::kNotRun && iterations_ >= stopping.max_iterations) stop_ = StopReason::kBudget;
      if (stop_ == StopReason::kNotRun && given < count) stop_ = StopReason::kExhausted;
      if (options_.block_size <= 0) block_size = std::min(2 * block_size, kLargestBlock);
    }
  }

  void ConsiderHints(const ConsensusHints& hints) {
    for (const ModelParameters& hint : hints.models)
      if (hint.size() == Parameters::SizeAtCompileTime && hint.allFinite()) Consider(hint, nullptr);
    if (hints.fit_weights.size() == 0) return;
    Parameters model;
    ++hypotheses_;
    if (Model::Fit(scorer_.points(), hints.fit_weights, &model)) Consider(model, nullptr);
  }

  void Finish(ConsensusResult* result) {
    for (const auto& entry : best_.entries()) {
      const Parameters model = Refined(Refitted(entry.model));
      const double score = FinalScore(model);
      if (result->model.size() > 0 && !(score > result->score)) continue;
      result->model = model;
      result->score = score;
    }
    if (result->model.size() > 0 && refit_ == Refit::kMixture && options_.sigma_prior > 0.0) EstimateSigmaToo(result);
    result->hypotheses = hypotheses_;
    result->iterations = iterations_;
    result->stop = stop_;
    result->rejected_early = rejected_early_;
    result->unique_minimal_sets = CountUniqueSets(taken_sets_, Model::kMinimalSize);
    for (std::size_t end = Model::kMinimalSize; end <= taken_sets_.size() && result->first_sets.size() < kReportedSets;
         end += Model::kMinimalSize)
      result->first_sets.emplace_back(taken_sets_.begin() + static_cast<std::ptrdiff_t>(end - Model::kMinimalSize),
                                      taken_sets_.begin() + static_cast<std::ptrdiff_t>(end));
    if (result->model.size() == 0 || CountInliers(result->model) < Model::kMinimalSize) {
      result->model.resize(0);
      result->score = 0.0;
      return;
    }
    result->inliers = InlierMask<Model>(scorer_.points(), result->model, threshold_);
    if constexpr (HasAmbiguityTest<Model>)
      result->ambiguous = ModelHooks<Model>::Ambiguous(scorer_.points(), threshold_, result->inliers);
    result->status = Status::kOk;
  }

 private:
  static constexpr int kFirstBlock = 64;
  static constexpr int kLargestBlock = 4096;

  /// What comes of one draw before earlier draws matter.
  struct Slot {
    int solutions = 0;
    Parameters models[Model::kMaxSolutions];
    double scores[Model::kMaxSolutions];
    SequentialTest::Outcome outcomes[Model::kMaxSolutions];
  };

  Score MakeScore(ScoreKind kind) const {
    return Score(kind, score_threshold_, mixture_.sigma, mixture_.Odds(options_.inlier_prior), residual_dof_);
  }

  void StartSequentialTest() {
    const std::vector<int> order = rng_.Fork("sprt").Permutation(scorer_.size());
    shuffled_points_.resize(scorer_.size(), Model::kDimension);
    for (int i = 0; i < scorer_.size(); ++i) shuffled_points_.row(i) = scorer_.points().row(order[i]);
    shuffled_.emplace(shuffled_points_);
    test_.emplace(Model::kMaxSolutions);
  }

  void Solve(int draw) {
    Slot& slot = slots_[draw];
    const int* set = sets_.data() + static_cast<std::size_t>(draw) * Model::kMinimalSize;
    const bool valid = std::all_of(set, set + Model::kMinimalSize, [&](int i) { return i >= 0 && i < scorer_.size(); });
    slot.solutions = valid ? Model::SolveMinimal(scorer_.points(), set, slot.models) : 0;
  }

  void ScoreSlot(int draw) {
    Slot& slot = slots_[draw];
    for (int i = 0; i < slot.solutions; ++i) {
      if (test_) slot.outcomes[i] = test_->Test(*shuffled_, slot.models[i], score_threshold_);
      if (!test_ || slot.outcomes[i].accepted) slot.scores[i] = scorer_(slot.models[i], score_, best_.bar());
    }
  }

  void TakeBlock(int given, const Stopping& stopping, int threads) {
    if (static_cast<int>(slots_.size()) < given) slots_.resize(given);
    // One thread scores each draw when its turn comes, against the newest bar.
    const bool ahead = threads > 1;
    if (ahead) ParallelFor(given, threads, [&](std::int64_t i) { Solve(static_cast<int>(i)); });
    int scored = 0;
    for (int i = 0; i < given && stop_ == StopReason::kNotRun; ++i) {
      if (!ahead) {
        Solve(i);
        ScoreSlot(i);
      } else if (i == scored) {
        ParallelFor(given - i, threads, [&](std::int64_t j) { ScoreSlot(i + static_cast<int>(j)); });
        scored = given;
      }
      // A changed test judges the draws that follow anew; a risen bar need not, its judgement would be the same.
      if (Take(i)) scored = i + 1;
      if (stopping.by_confidence && iterations_ >= std::max(stopping.min_iterations, needed_))
        stop_ = StopReason::kConfidence;
    }
  }

  /// Takes the next draw in; true when the sequential test has changed.
  bool Take(int draw) {
    const Slot& slot = slots_[draw];
    const int* set = sets_.data() + static_cast<std::size_t>(draw) * Model::kMinimalSize;
    taken_sets_.insert(taken_sets_.end(), set, set + Model::kMinimalSize);
    ++iterations_;
    hypotheses_ += std::max(1, slot.solutions);
    test_changed_ = false;
    for (int i = 0; i < slot.solutions; ++i) {
      if (test_ && !slot.outcomes[i].accepted) {
        ++rejected_early_;
        test_changed_ |= test_->AddRejected(slot.outcomes[i]);
      } else {
        ConsiderScored({slot.models[i], slot.scores[i]}, set);
      }
    }
    if (test_changed_) UpdateNeeded();
    return test_changed_;
  }

  void Consider(const Parameters& model, const int* set) {
    ConsiderScored({model, scorer_(model, score_, best_.bar())}, set);
  }

  /// set: what the model was solved from; null when it was given.
  void ConsiderScored(const ScoredModel<Model>& found, const int* set) {
    const bool is_best = found.score > best_.best();
    best_.Offer(found.model, found.score);
    if (!is_best) return;
    ScoredModel<Model> optimized = found;
    if (set != nullptr) optimized = Mended(found, set, false);
    optimized = OptimizedLocally(optimized);
    // Optimisation gathers points until a model is as degenerate as they are, so it is asked about once more.
    if (local_ != LocalOptimization::kNone || set == nullptr) optimized = Mended(optimized, nullptr, true);
    best_.Offer(optimized.model, optimized.score);
    best_inliers_ = CountInliers(best_.entries().front().model);
    if (test_) test_changed_ |= test_->AddBest(static_cast<double>(best_inliers_) / scorer_.size());
    UpdateNeeded();
  }

  void UpdateNeeded() {
    const double good = AllInlierProbability(best_inliers_, scorer_.size(), Model::kMinimalSize);
    needed_ = DrawsForConfidence(test_ ? good * test_->PassProbability() : good, options_.confidence);
  }

  /// The best of the model and what the model's degeneracy hook makes of it, optimised locally if so asked.
  ScoredModel<Model> Mended(const ScoredModel<Model>& found, [[maybe_unused]] const int* set,
                            [[maybe_unused]] bool optimize) {
    ScoredModel<Model> best = found;
    if constexpr (HasDegeneracyRecovery<Model>) {
      Parameters others[Model::kMaxSolutions];
      const Rng rng = rng_.Fork("degeneracy", mended_runs_++);
      const int count = ModelHooks<Model>::RecoverFromDegeneracy(scorer_.points(), set, found.model, score_threshold_,
                                                                 rng, others, &hypotheses_);
      for (int i = 0; i < count; ++i) {
        const ScoredModel<Model> other{others[i], scorer_(others[i], score_, best.score)};
        if (other.score > best.score) best = other;
      }
      if (optimize && best.score > found.score) best = OptimizedLocally(best);
    }
    return best;
  }

  ScoredModel<Model> OptimizedLocally(const ScoredModel<Model>& start) {
    if (local_ == LocalOptimization::kNone) return start;
    const Rng rng = rng_.Fork("local_optimization", local_runs_++);
    switch (local_) {
      case LocalOptimization::kInnerSamples:
        return OptimizeLocally<Model>(scorer_, score_, score_threshold_, options_.local_samples, start, rng,
                                      &hypotheses_);
      case LocalOptimization::kReweighted:
        return OptimizeReweighted<Model>(scorer_, score_, MagsacLoss(score_threshold_, residual_dof_),
                                         options_.irls_rounds, start, &hypotheses_);
      case LocalOptimization::kGraphCut:
        if (!graph_cut_) graph_cut_.emplace(scorer_.points(), options_.graph_neighbors, options_.spatial_weight);
        return OptimizeByGraphCut<Model>(scorer_, score_, score_threshold_, *graph_cut_, options_.local_samples, start,
                                         rng, &hypotheses_);
      case LocalOptimization::kRefine: {
        const Parameters model = RefinedOnce(start.model);
        const double score = scorer_(model, score_, start.score);
        return score > start.score ? ScoredModel<Model>{model, score} : start;
      }
      case LocalOptimization::kNone:
        break;
    }
    return start;
  }

  int CountInliers(const Parameters& model) const {
    return static_cast<int>((scorer_.Residuals(model).array() <= threshold_).count());
  }

  double InlierShare(const Parameters& model) const {
    return static_cast<double>(CountInliers(model)) / scorer_.size();
  }

  double FinalScore(const Parameters& model) const {
    if (final_kind_ == ScoreKind::kGaussianUniform) return MixtureScore(mixture_, scorer_.Residuals(model));
    return scorer_(model, final_);
  }

  Parameters Refitted(const Parameters& start) {
    Parameters model = start;
    const double threshold = options_.refit_threshold_factor * threshold_;
    if (refit_ == Refit::kInliers) {
      ++hypotheses_;
      FitInliers(scorer_, threshold, &model);
    } else if (refit_ == Refit::kIterated) {
      model = Iterated(start, threshold);
    } else if (refit_ == Refit::kMixture) {
      hypotheses_ += MixtureRefit<Model>(scorer_.points(), mixture_, InlierShare(start), &model);
    } else if (refit_ == Refit::kReweighted) {
      model = Reweighted(start, threshold);
    }
    return CountInliers(model) < Model::kMinimalSize ? start : model;
  }

  /// By the final score where that is a sum over points; the mixture's own is compared once, at the end.
  Parameters Reweighted(const Parameters& start, double threshold) {
    const MagsacLoss loss(options_.score_threshold_factor * threshold, residual_dof_);
    const ScoredModel<Model> found{start, scorer_(start, final_)};
    const Parameters model =
        OptimizeReweighted<Model>(scorer_, final_, loss, options_.irls_rounds, found, &hypotheses_).model;
    return FinalScore(model) >= FinalScore(start) ? model : start;
  }

  /// What the model's own refinement gives; the model itself without one.
  Parameters RefinedOnce(const Parameters& start) {
    Parameters model = start;
    if constexpr (HasRefine<Model>) {
      ++hypotheses_;
      if (!ModelHooks<Model>::Refine(scorer_.points(), score_threshold_, &model) || !model.allFinite()) return start;
    }
    return model;
  }

  Parameters Refined(const Parameters& start) {
    if (!refine_at_end_) return start;
    const Parameters model = RefinedOnce(start);
    const bool keep = CountInliers(model) >= Model::kMinimalSize && FinalScore(model) >= FinalScore(start);
    return keep ? model : start;
  }

  /// Once, for the model that won with σ assumed: candidates that each chose their own σ would not compare as well
  /// (docs/experiments.md).
  void EstimateSigmaToo(ConsensusResult* result) {
    Parameters model = result->model;
    hypotheses_ += MixtureRefit<Model>(scorer_.points(), mixture_, InlierShare(model), &model, options_.sigma_prior);
    if (CountInliers(model) < Model::kMinimalSize) return;
    result->model = model;
    result->score = FinalScore(model);
  }

  Parameters Iterated(const Parameters& start, double threshold) {
    Parameters model = start;
    double score = FinalScore(start);
    for (int round = 0; round < options_.refit_rounds; ++round) {
      Parameters next = model;
      ++hypotheses_;
      if (!FitInliers(scorer_, threshold, &next)) break;
      const double next_score = FinalScore(next);
      if (!(next_score >= score)) break;
      const bool settled = next == model;
      model = next;
      score = next_score;
      if (settled) break;
    }
    return model;
  }

  const ConsensusOptions& options_;
  double threshold_;
  double score_threshold_;
  int residual_dof_;
  Mixture mixture_;
  LocalOptimization local_;
  Refit refit_;
  bool refine_at_end_;
  ScoreKind final_kind_;
  Rng rng_;
  Scorer<Model> scorer_;
  Score score_;
  Score final_;
  BestHypotheses<Model> best_;
  std::optional<GraphCut> graph_cut_;
  PointMatrix shuffled_points_;
  std::optional<Scorer<Model>> shuffled_;
  std::optional<SequentialTest> test_;
  bool test_changed_ = false;
  std::vector<Slot> slots_;
  std::vector<int> sets_;
  std::vector<int> taken_sets_;
  StopReason stop_ = StopReason::kNotRun;
  std::int64_t iterations_ = 0;
  std::int64_t needed_ = kNeverEnough;
  int best_inliers_ = 0;
  int hypotheses_ = 0;
  int rejected_early_ = 0;
  std::uint64_t local_runs_ = 0;
  std::uint64_t mended_runs_ = 0;
};

/// Whether squares of a length, and quotients by them, are ordinary numbers.
inline bool IsUsableScale(double length) { return length >= kLeastScale && length <= kLargestScale; }

/// Whether the loop can run; if not, *result says why.
template <MinimalModel Model>
bool CheckProblem(const PointMatrix& points, double threshold, const ConsensusOptions& options,
                  ConsensusResult* result) {
  result->status = CheckPoints<Model>(points);
  if (result->status != Status::kOk) return false;
  result->status = Status::kNoModel;
  const double scored = options.score_threshold_factor * threshold;
  return IsUsableScale(threshold) && IsUsableScale(scored) && IsUsableScale(options.sigma_factor * threshold) &&
         IsUsableScale(options.refit_threshold_factor * threshold) &&
         IsUsableScale(options.refit_threshold_factor * scored);
}

}  // namespace consensus_internal

template <MinimalModel Model>
Status CheckPoints(const PointMatrix& points) {
  if (points.rows() < Model::kMinimalSize) return Status::kTooFewPoints;
  if (points.cols() != Model::kDimension || !points.allFinite()) return Status::kDegenerate;
  if constexpr (requires { Model::Determined(points); }) {
    if (!Model::Determined(points)) return Status::kDegenerate;
  }
  return Status::kOk;
}

template <MinimalModel Model>
ConsensusResult SampleConsensus(const PointMatrix& points, double inlier_threshold,
                                const std::vector<int>& minimal_sets, const ConsensusOptions& options, Rng rng,
                                const ConsensusHints& hints) {
  ConsensusResult result;
  if (!consensus_internal::CheckProblem<Model>(points, inlier_threshold, options, &result)) return result;
  consensus_internal::Run<Model> run(points, inlier_threshold, options, rng);
  const auto sets = static_cast<std::int64_t>(minimal_sets.size()) / Model::kMinimalSize;
  run.ConsiderSource(GivenSource(minimal_sets), {sets, sets, false}, 1);
  run.ConsiderHints(hints);
  run.Finish(&result);
  return result;
}

template <MinimalModel Model>
ConsensusResult SampleConsensus(const PointMatrix& points, double inlier_threshold, const HypothesisSource& source,
                                const ConsensusOptions& options, Rng rng, const ConsensusHints& hints, int threads) {
  ConsensusResult result;
  if (!consensus_internal::CheckProblem<Model>(points, inlier_threshold, options, &result)) return result;
  consensus_internal::Run<Model> run(points, inlier_threshold, options, rng);
  run.ConsiderHints(hints);
  run.ConsiderSource(source, {options.max_iterations, options.min_iterations, StopsByConfidence(options.stopping)},
                     threads);
  run.Finish(&result);
  return result;
}

}  // namespace diffsac
