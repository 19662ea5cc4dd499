#pragma once

// The loop behind sample_consensus.h, for the files that instantiate it for a model.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "diffsac/consensus/local/final_refiner.h"
#include "diffsac/consensus/local/local_optimizer.h"
#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/consensus/samplers/minimal_sampler.h"
#include "diffsac/consensus/scores/scorer.h"
#include "diffsac/core/parallel.h"

namespace diffsac {

/// The best K hypotheses seen so far that differ in their inliers, best first; the earlier one first where scores tie.
/// Two differ where less than `alike` of the inliers of either are inliers of both.
template <MinimalModel Model>
class BestHypotheses {
 public:
  struct Entry {
    typename Model::Parameters model;
    double score;
    std::vector<std::uint8_t> inliers;  ///< At `threshold`; empty when only one hypothesis is kept.
  };

  /// least: share of the best's score that another must have. Borrows the scorer.
  BestHypotheses(const Scorer<Model>& scorer, double threshold, int capacity, double alike = 1.0, double least = 0.0)
      : scorer_(scorer),
        threshold_(threshold),
        capacity_(capacity),
        alike_(alike),
        least_(least),
        bar_(capacity > 0 ? -1.0 : std::numeric_limits<double>::infinity()) {}

  /// A score must be above this to enter. It never falls, not even where one hypothesis takes the place of several:
  /// draws that were scored against an older bar (HypothesisBlock) may have been given up.
  double bar() const { return entries_.empty() || least_ == 0.0 ? bar_ : std::max(bar_, least_ * best()); }
  /// A score must be above this to become the best.
  double best() const { return entries_.empty() ? -1.0 : entries_.front().score; }
  const std::vector<Entry>& entries() const { return entries_; }

  void Offer(const typename Model::Parameters& model, double score) {
    if (!(score > bar())) return;
    Entry entry{model, score, {}};
    if (capacity_ > 1) {
      const Eigen::VectorXd residuals = scorer_.Residuals(model);
      entry.inliers.resize(residuals.size());
      for (Eigen::Index i = 0; i < residuals.size(); ++i) entry.inliers[i] = residuals[i] <= threshold_;
      const auto twin = [&](const Entry& other) { return Alike(other.inliers, entry.inliers); };
      const auto worse =
          std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return score > e.score; });
      if (std::any_of(entries_.begin(), worse, twin)) return;
      entries_.erase(std::remove_if(worse, entries_.end(), twin), entries_.end());
    }
    const auto place =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& other) { return score > other.score; });
    entries_.insert(place, std::move(entry));
    if (static_cast<int>(entries_.size()) > capacity_) entries_.pop_back();
    if (static_cast<int>(entries_.size()) == capacity_) bar_ = std::max(bar_, entries_.back().score);
  }

 private:
  bool Alike(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) const {
    if (alike_ == 1.0) return a == b;
    int both = 0, either = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      both += a[i] & b[i];
      either += a[i] | b[i];
    }
    return both >= alike_ * either;
  }

  const Scorer<Model>& scorer_;
  double threshold_;
  int capacity_;
  double alike_;
  double least_;
  double bar_;
  std::vector<Entry> entries_;
};

/// A block of minimal sets, and what comes of each before earlier draws matter: the models that it is solved to, and
/// what they score. Several threads solve and score all that is left of a block at once; one does each draw when it is
/// asked for. Either way the draws come in their order and are the same.
template <MinimalModel Model>
class HypothesisBlock {
 public:
  /// What comes of one minimal set.
  struct Draw {
    const int* set = nullptr;  ///< γ indices.
    int solutions = 0;
    typename Model::Parameters models[Model::kMaxSolutions];
    double scores[Model::kMaxSolutions];
  };

  /// capacity: sets at a time, 0: from 64 growing to 4096. threads: 0 for all cores. Borrows the rest.
  HypothesisBlock(const Scorer<Model>& scorer, const Score& score, int capacity, int threads)
      : scorer_(scorer),
        score_(score),
        grows_(capacity <= 0),
        capacity_(grows_ ? kFirstCapacity : capacity),
        threads_(threads <= 0 ? HardwareThreads() : threads) {}

  /// Draws sets in place of the last ones, as many as there is room for and `most` at most; false when the sampler had
  /// fewer.
  bool Fill(MinimalSampler& sampler, std::int64_t most) {
    const std::int64_t count = std::min<std::int64_t>(capacity_, most);
    if (grows_) capacity_ = std::min(2 * capacity_, kLastCapacity);
    sets_ = DrawSets(sampler, Model::kMinimalSize, count);
    size_ = static_cast<int>(sets_.size()) / Model::kMinimalSize;
    if (static_cast<int>(draws_.size()) < size_) draws_.resize(size_);
    next_ = scored_ = 0;
    if (threads_ > 1) ParallelFor(size_, threads_, [&](std::int64_t i) { Solve(static_cast<int>(i)); });
    return size_ == count;
  }

  /// The next draw, null after the last one. bar: what its score must exceed to matter (Scorer); draws that were scored
  /// against an older, lower bar need not be scored again.
  const Draw* Next(double bar) {
    if (next_ == size_) return nullptr;
    if (threads_ <= 1) {
      Solve(next_);
      ScoreOne(next_, bar);
    } else if (next_ == scored_) {
      ParallelFor(size_ - next_, threads_, [&](std::int64_t i) { ScoreOne(next_ + static_cast<int>(i), bar); });
      scored_ = size_;
    }
    return &draws_[next_++];
  }

 private:
  void Solve(int i) {
    draws_[i].set = sets_.data() + static_cast<std::size_t>(i) * Model::kMinimalSize;
    draws_[i].solutions = SolveSet<Model>(scorer_.points(), draws_[i].set, draws_[i].models);
  }

  void ScoreOne(int i, double bar) {
    Draw& draw = draws_[i];
    for (int k = 0; k < draw.solutions; ++k) draw.scores[k] = scorer_(draw.models[k], score_, bar);
  }

  static constexpr int kFirstCapacity = 64;
  static constexpr int kLastCapacity = 4096;

  const Scorer<Model>& scorer_;
  const Score& score_;
  bool grows_;
  int capacity_;
  int threads_;
  std::vector<int> sets_;
  std::vector<Draw> draws_;
  int size_ = 0;
  int next_ = 0;
  int scored_ = 0;  ///< Draws before this one are scored. With several threads alone.
};

/// What scores take into account of the priors. Priors that are not one number a point say nothing; what is no
/// probability counts as the nearest one, and what is no number as 0.
inline ScorePrior PriorOf(const EstimationPriors& priors, const ConsensusOptions& options, Eigen::Index num_points) {
  ScorePrior prior{{}, priors.cameras, priors.turns, options.turn_weight};
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
      : options_(options),
        scales_(scales),
        scorer_(points, PriorOf(priors, options, points.rows())),
        score_(scales.MakeScore(options.score, options.inlier_prior)),
        best_(scorer_, scales.score_threshold, std::max(1, options.refit_candidates),
              HasRivals<Model>     ? kSameRival
              : options.basins > 0 ? kSameBasin
                                   : 1.0,
              options.basins > 0 ? kLeastShare : 0.0),
        starts_(scorer_, scales.score_threshold, options.basins, kSameBasin, kLeastShare),
        improve_(scorer_, score_, options, scales_, rng),
        refine_(scorer_, options, scales_),
        rule_(options, points.rows(), Model::kMinimalSize),
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
    rule_.SetDrawnPoints(sampler.DrawnPoints(Model::kMinimalSize));
    for (result_.stop = rule_.After(0); result_.stop == StopReason::kNotRun;) {
      const bool more = block_.Fill(sampler, options_.max_iterations - result_.iterations);
      while (result_.stop == StopReason::kNotRun) {
        const auto* draw = block_.Next(Bar());
        if (draw == nullptr) break;
        Take(*draw);
        result_.stop = rule_.After(result_.iterations);
      }
      if (result_.stop == StopReason::kNotRun && !more) result_.stop = StopReason::kExhausted;
    }
  }

  ConsensusResult Finish() {
    const bool confident = result_.stop == StopReason::kConfidence;
    if (!confident && !sure_) ImproveStarts();
    std::optional<ScoredModel<Model>> chosen = refine_(best_.entries(), &result_.hypotheses);
    if (chosen && !confident) Polish(&*chosen);
    result_.unique_minimal_sets = CountUniqueSets(sets_, Model::kMinimalSize);
    result_.first_sets = FirstSets(sets_, Model::kMinimalSize);
    if (!chosen || refine_.CountInliers(chosen->model) < Model::kMinimalSize) return std::move(result_);
    if constexpr (HasFocalPosterior<Model>) result_.focal = refine_.Marginalise(&*chosen, &result_.hypotheses);
    if constexpr (HasOtherMinimum<Model>) result_.other = refine_.OtherMinimum(&*chosen, &result_.hypotheses);
    if constexpr (HasRivals<Model>) refine_.FindRival(best_.entries(), *chosen, &result_);
    refine_.Report(*chosen, &result_);
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
      if (!(draw.scores[i] > Bar())) continue;
      best_.Offer(draw.models[i], draw.scores[i]);
      if (!sure_) starts_.Offer(draw.models[i], draw.scores[i]);
      if (!(draw.scores[i] > best_minimal_)) continue;
      best_minimal_ = draw.scores[i];
      rise = i;
    }
    if (rise >= 0) Improve({draw.models[rise], draw.scores[rise]}, draw.set, before);
  }

  /// What a draw must exceed to matter. It never falls.
  double Bar() const {
    if (settled_) return best_minimal_;
    const double bar = std::min(best_.bar(), best_minimal_);
    return sure_ ? bar : std::min(bar, starts_.bar());
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
    if (!(best_.best() > before)) return;
    const int inliers = refine_.CountInliers(best_.entries().front().model);
    rule_.Update(inliers);
    sure_ = sure_ || rule_.Finds(options_.max_iterations);
    settled_ = settled_ || (options_.basins > 0 && sure_ && inliers >= kManyInliers);
  }

  /// The loop improves a draw only where it is the best so far, of which there are seven in a thousand; a draw near a
  /// better optimum may be worse than one near another.
  void ImproveStarts() {
    for (const auto& start : starts_.entries()) Improve({start.model, start.score}, nullptr, best_.best());
  }

  /// Looks for a better optimum near by: again from random samples of the chosen model's inliers.
  void Polish(ScoredModel<Model>* chosen) {
    for (int i = 0; i < options_.polish; ++i) {
      const std::vector<ScoredModel<Model>> other{improve_.Again(chosen->model, &result_.hypotheses)};
      const std::optional<ScoredModel<Model>> refined = refine_(other, &result_.hypotheses);
      if (refined && refined->score > chosen->score) *chosen = *refined;
    }
  }

  /// Of the best one's score, what other basins' models have at least: a far worse one does not become the best.
  static constexpr double kLeastShare = 0.5;
  /// Models of fewer inliers may have rivals even where all draws will do.
  static constexpr int kManyInliers = 100;
  /// Of two models of one basin so many inliers are common; of a model that may have rivals, for which there would be
  /// no room, most of them.
  static constexpr double kSameBasin = 0.9, kSameRival = 0.5;

  const ConsensusOptions& options_;
  const NoiseScales scales_;
  const Scorer<Model> scorer_;
  const Score score_;
  BestHypotheses<Model> best_;
  BestHypotheses<Model> starts_;  ///< Draws, as they were solved.
  LocalOptimizer<Model> improve_;
  FinalRefiner<Model> refine_;
  StoppingRule rule_;
  HypothesisBlock<Model> block_;
  /// The best score of a draw before it is improved, what the next draw to be improved must exceed. Were it the best
  /// score of all, an improved model's, hardly any draw after the first improvement would do (PoseLib,
  /// robust/ransac_impl.h, keeps the two apart).
  double best_minimal_ = -1.0;
  bool sure_ = false;       ///< All draws will do, and other starts are not asked for.
  bool settled_ = false;    ///< Nor are other candidates.
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
