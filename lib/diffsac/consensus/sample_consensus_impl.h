#pragma once

// The definitions behind sample_consensus.h, for the files that instantiate them for a model.

#include <algorithm>
#include <optional>
#include <vector>

#include "diffsac/consensus/degeneracy_recovery.h"
#include "diffsac/consensus/final_refiner.h"
#include "diffsac/consensus/minimal_solver.h"
#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/sprt.h"
#include "diffsac/core/parallel.h"

namespace diffsac {
namespace consensus_internal {

/// One search over one point set.
///
/// A block of sets is drawn from the source, solved and scored by all threads; then its draws are taken in order, and
/// everything that depends on earlier draws (the best, local optimisation, the stopping rule) happens there. Draws
/// behind the stop are thrown away. So neither threads nor blocks can change anything.
template <MinimalModel Model>
class Search {
 public:
  using Parameters = typename Model::Parameters;

  Search(const PointMatrix& points, const NoiseScales& scales, const ConsensusOptions& options, const Rng& rng,
         int threads)
      : options_(options),
        scales_(scales),
        threads_(threads <= 0 ? HardwareThreads() : threads),
        solve_(points),
        scorer_(points),
        score_(scales.MakeScore(options.score, options.inlier_prior)),
        best_(points, scales.score_threshold, std::max(1, options.refit_candidates)),
        recover_(scorer_, score_, scales.score_threshold, rng),
        optimize_(scorer_, score_, options, scales, rng),
        refine_(scorer_, options, scales),
        rule_(options.stopping, options.max_iterations, options.min_iterations, options.confidence, points.rows(),
              Model::kMinimalSize) {
    if (options.sprt) test_.emplace(points, scales.score_threshold, rng.Fork("sprt"));
  }

  void Consider(const ConsensusHints& hints) {
    for (const ModelParameters& hint : hints.models)
      if (hint.size() == Parameters::SizeAtCompileTime && hint.allFinite()) Consider(Parameters(hint), nullptr);
    if (hints.fit_weights.size() == 0) return;
    Parameters model;
    ++hypotheses_;
    if (Model::Fit(scorer_.points(), hints.fit_weights, &model)) Consider(model, nullptr);
  }

  void Draw(HypothesisSource& source) {
    int block = options_.block_size > 0 ? options_.block_size : kFirstBlock;
    for (stop_ = rule_.After(iterations_); stop_ == StopReason::kNotRun;) {
      const std::int64_t count = std::min<std::int64_t>(block, rule_.max_iterations() - iterations_);
      sets_ = DrawSets(source, Model::kMinimalSize, count);
      const int drawn = static_cast<int>(sets_.size()) / Model::kMinimalSize;
      TakeBlock(drawn);
      if (stop_ == StopReason::kNotRun && drawn < count) stop_ = StopReason::kExhausted;
      if (options_.block_size <= 0) block = std::min(2 * block, kLargestBlock);
    }
  }

  ConsensusResult Finish() {
    ConsensusResult result;
    const std::optional<ScoredModel<Model>> chosen = refine_(best_.entries(), &hypotheses_);
    result.hypotheses = hypotheses_;
    result.iterations = iterations_;
    result.stop = stop_;
    result.rejected_early = rejected_early_;
    result.unique_minimal_sets = CountUniqueSets(taken_sets_, Model::kMinimalSize);
    result.first_sets = FirstSets(taken_sets_, Model::kMinimalSize);
    if (!chosen || refine_.CountInliers(chosen->model) < Model::kMinimalSize) return result;
    result.status = Status::kOk;
    result.model = chosen->model;
    result.score = chosen->score;
    result.inliers = InlierMask<Model>(scorer_.points(), chosen->model, scales_.threshold);
    if constexpr (HasAmbiguityTest<Model>)
      result.ambiguous = ModelHooks<Model>::Ambiguous(scorer_.points(), scales_.threshold, result.inliers);
    return result;
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

  const int* SetOf(int draw) const { return sets_.data() + static_cast<std::size_t>(draw) * Model::kMinimalSize; }

  void SolveSlot(int draw) { slots_[draw].solutions = solve_(SetOf(draw), slots_[draw].models); }

  void ScoreSlot(int draw) {
    Slot& slot = slots_[draw];
    for (int i = 0; i < slot.solutions; ++i) {
      if (test_) slot.outcomes[i] = test_->Test(slot.models[i]);
      if (!test_ || slot.outcomes[i].accepted) slot.scores[i] = scorer_(slot.models[i], score_, best_.bar());
    }
  }

  void TakeBlock(int drawn) {
    if (static_cast<int>(slots_.size()) < drawn) slots_.resize(drawn);
    // One thread scores each draw when its turn comes, against the newest bar.
    const bool ahead = threads_ > 1;
    if (ahead) ParallelFor(drawn, threads_, [&](std::int64_t i) { SolveSlot(static_cast<int>(i)); });
    int scored = 0;
    for (int i = 0; i < drawn && stop_ == StopReason::kNotRun; ++i) {
      if (!ahead) {
        SolveSlot(i);
        ScoreSlot(i);
      } else if (i == scored) {
        ParallelFor(drawn - i, threads_, [&](std::int64_t j) { ScoreSlot(i + static_cast<int>(j)); });
        scored = drawn;
      }
      // A changed test judges the draws that follow anew; a risen bar need not, its judgement would be the same.
      if (Take(i)) scored = i + 1;
      stop_ = rule_.After(iterations_);
    }
  }

  /// Takes the next draw in; true when the sequential test has changed.
  bool Take(int draw) {
    const Slot& slot = slots_[draw];
    const int* set = SetOf(draw);
    taken_sets_.insert(taken_sets_.end(), set, set + Model::kMinimalSize);
    ++iterations_;
    hypotheses_ += std::max(1, slot.solutions);
    test_changed_ = false;
    for (int i = 0; i < slot.solutions; ++i) {
      if (test_ && !slot.outcomes[i].accepted) {
        ++rejected_early_;
        test_changed_ |= test_->AddRejected(slot.outcomes[i]);
      } else {
        Take({slot.models[i], slot.scores[i]}, set);
      }
    }
    if (test_changed_) UpdateRule();
    return test_changed_;
  }

  void Consider(const Parameters& model, const int* set) { Take({model, scorer_(model, score_, best_.bar())}, set); }

  /// set: what the model was solved from; null when it was given.
  void Take(const ScoredModel<Model>& found, const int* set) {
    const bool is_best = found.score > best_.best();
    best_.Offer(found.model, found.score);
    if (!is_best) return;
    const ScoredModel<Model> improved = Improved(found, set);
    best_.Offer(improved.model, improved.score);
    best_inliers_ = refine_.CountInliers(best_.entries().front().model);
    if (test_) test_changed_ |= test_->AddBest(static_cast<double>(best_inliers_) / scorer_.size());
    UpdateRule();
  }

  /// A new best hypothesis, mended where it is degenerate and optimised locally.
  ScoredModel<Model> Improved(const ScoredModel<Model>& found, const int* set) {
    ScoredModel<Model> best = optimize_(set != nullptr ? recover_(found, set, &hypotheses_) : found, &hypotheses_);
    // Optimisation gathers points until a model is as degenerate as they are, so it is asked about once more.
    if (optimize_.active() || set == nullptr) {
      const ScoredModel<Model> mended = recover_(best, nullptr, &hypotheses_);
      if (mended.score > best.score) best = optimize_(mended, &hypotheses_);
    }
    return best;
  }

  void UpdateRule() { rule_.Update(best_inliers_, test_ ? test_->PassProbability() : 1.0); }

  const ConsensusOptions& options_;
  const NoiseScales& scales_;
  int threads_;
  MinimalSolver<Model> solve_;
  Scorer<Model> scorer_;
  Score score_;
  BestHypotheses<Model> best_;
  DegeneracyRecovery<Model> recover_;
  LocalOptimizer<Model> optimize_;
  FinalRefiner<Model> refine_;
  StoppingRule rule_;
  std::optional<SequentialFilter<Model>> test_;
  bool test_changed_ = false;
  std::vector<Slot> slots_;
  std::vector<int> sets_;
  std::vector<int> taken_sets_;
  StopReason stop_ = StopReason::kNotRun;
  std::int64_t iterations_ = 0;
  int best_inliers_ = 0;
  int hypotheses_ = 0;
  int rejected_early_ = 0;
};

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
ConsensusResult SampleConsensus(const PointMatrix& points, double inlier_threshold, HypothesisSource& source,
                                const ConsensusOptions& options, const Rng& rng, const ConsensusHints& hints,
                                int threads) {
  ConsensusResult failed;
  failed.status = CheckPoints<Model>(points);
  if (failed.status != Status::kOk) return failed;
  failed.status = Status::kNoModel;
  if (!UsableScales(inlier_threshold, options)) return failed;
  const NoiseScales scales = ScalesOf<Model>(points, inlier_threshold, options);
  consensus_internal::Search<Model> search(points, scales, options, rng, threads);
  search.Consider(hints);
  search.Draw(source);
  return search.Finish();
}

}  // namespace diffsac
