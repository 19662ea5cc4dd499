#pragma once

// The loop: minimal sets are drawn, solved and scored, the best ones optimised, until there are draws enough. It knows
// the model by MinimalModel (geometry/model.h) and all else by its policies (policies.h).

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "diffsac/ransac/best_hypotheses.h"
#include "diffsac/ransac/consensus_result.h"
#include "diffsac/ransac/hypothesis_block.h"
#include "diffsac/ransac/policies.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac::ransac {

struct LoopOptions {
  std::int64_t max_iterations = 1000;
  int num_threads = 1;  ///< 0: all cores.
  int block_size = 0;   ///< Sets that are drawn at a time, 0: from 64 growing to 4096. Results do not depend on it.
  int candidates = 1;   ///< So many of the best hypotheses that differ are refined after the draws.
  /// Hypotheses differ where less than the share `alike` of the points within `threshold` of either is within it of
  /// both.
  double threshold = 0.0;
  double alike = 1.0;
  /// Unless the search ended confident: so many of the best draws that differ are optimised as well, and the chosen
  /// model so many times more from other samples of its inliers.
  int lo_starts = 0;
  int lo_restarts = 0;
};

/// Of two models of one optimum so many inliers are common.
inline constexpr double kSameOptimum = 0.9;

/// One search over one point set.
///
/// A block of sets is drawn from the sampler, solved and scored by all threads; then its draws are taken in order, and
/// everything that depends on earlier draws (the best, local optimisation, the stopping rule) happens there. Draws
/// behind the stop are thrown away. So neither threads nor blocks can change anything.
template <MinimalModel Model, class Scorer, class Optimizer, class Rule, class Refiner>
class Loop {
 public:
  using Parameters = typename Model::Parameters;

  /// Borrows points and policies.
  Loop(const PointMatrix& points, const Policies<Scorer, Optimizer, Rule, Refiner>& policies,
       const LoopOptions& options)
      : options_(options),
        policies_(policies),
        best_(policies.scorer, options.threshold, std::max(1, options.candidates), options.alike, LeastShare()),
        starts_(policies.scorer, options.threshold, options.lo_starts, kSameOptimum, kLeastShare),
        block_(points, policies.scorer, options.block_size, options.num_threads) {}

  /// A model that was given, not drawn: it may be as good as an improved one, and bars no minimal model's way.
  void Consider(const Parameters& model) {
    const double before = best_.best();
    const ScoredModel<Model> given{model, policies_.scorer(model, best_.score_to_beat())};
    best_.Offer(given.model, given.score);
    if (given.score > before) Improve(given, nullptr, before);
  }

  void Draw() {
    policies_.stop.SetDrawnPoints(policies_.sampler.DrawnPoints(Model::kMinimalSize));
    for (result_.stop = policies_.stop.After(0); result_.stop == StopReason::kNotRun;) {
      const bool more = block_.Fill(policies_.sampler, options_.max_iterations - result_.iterations);
      while (result_.stop == StopReason::kNotRun) {
        const auto* draw = block_.Next(ScoreToBeat());
        if (draw == nullptr) break;
        Take(*draw);
        result_.stop = policies_.stop.After(result_.iterations);
      }
      if (result_.stop == StopReason::kNotRun && !more) result_.stop = StopReason::kExhausted;
    }
  }

  ConsensusResult Finish() {
    const bool confident = result_.stop == StopReason::kConfidence;
    if (!confident && !sure_) ImproveStarts();
    const auto& candidates = best_.entries();
    std::optional<ScoredModel<Model>> chosen = policies_.refine(candidates, &result_.hypotheses);
    if (chosen && !confident) Restart(&*chosen);
    result_.unique_minimal_sets = CountUniqueSets(sets_, Model::kMinimalSize);
    result_.first_sets = FirstSets(sets_, Model::kMinimalSize);
    if (chosen) policies_.refine.Complete(candidates, *chosen, &result_);
    return std::move(result_);
  }

 private:
  void Take(const typename HypothesisBlock<Model, Scorer>::Draw& draw) {
    sets_.insert(sets_.end(), draw.set, draw.set + Model::kMinimalSize);
    ++result_.iterations;
    result_.hypotheses += std::max(1, draw.solutions);
    const double before = best_.best();
    int rise = -1;
    for (int i = 0; i < draw.solutions; ++i) {
      if (!(draw.scores[i] > ScoreToBeat())) continue;
      std::vector<std::uint8_t> inliers;
      best_.Offer(draw.models[i], draw.scores[i], &inliers);
      if (!sure_) starts_.Offer(draw.models[i], draw.scores[i], &inliers);
      if (!(draw.scores[i] > best_minimal_)) continue;
      best_minimal_ = draw.scores[i];
      rise = i;
    }
    if (rise >= 0) Improve({draw.models[rise], draw.scores[rise]}, draw.set, before);
  }

  /// What a draw must exceed to matter. It never falls.
  double ScoreToBeat() const {
    if (settled_) return best_minimal_;
    const double score_to_beat = std::min(best_.score_to_beat(), best_minimal_);
    return sure_ ? score_to_beat : std::min(score_to_beat, starts_.score_to_beat());
  }

  /// set: what the model was solved from; null when it was given. before: the best score before it.
  void Improve(const ScoredModel<Model>& found, const int* set, double before) {
    const ScoredModel<Model> improved = policies_.optimize(found, set, before, &result_.hypotheses);
    best_.Offer(improved.model, improved.score);
    if (!(best_.best() > before)) return;
    policies_.stop.Update(policies_.refine.Inliers(best_.entries().front().model));
    sure_ = sure_ || policies_.stop.Finds(options_.max_iterations);
    settled_ = settled_ || (options_.lo_starts > 0 && sure_ && policies_.stop.inliers() >= kManyInliers);
  }

  /// The loop improves a draw only where it is the best so far, of which there are seven in a thousand; a draw near a
  /// better optimum may be worse than one near another.
  void ImproveStarts() {
    for (const auto& start : starts_.entries()) Improve({start.model, start.score}, nullptr, best_.best());
  }

  /// Looks for a better optimum near by: again from random samples of the chosen model's inliers.
  void Restart(ScoredModel<Model>* chosen) {
    for (int i = 0; i < options_.lo_restarts; ++i) {
      const std::vector<ScoredModel<Model>> other{policies_.optimize.Again(chosen->model, &result_.hypotheses)};
      const std::optional<ScoredModel<Model>> refined = policies_.refine(other, &result_.hypotheses);
      if (refined && refined->score > chosen->score) *chosen = *refined;
    }
  }

  /// Of the best one's score, what other optima's models have at least: a far worse one does not become the best.
  static constexpr double kLeastShare = 0.5;
  double LeastShare() const { return options_.lo_starts > 0 ? kLeastShare : 0.0; }
  /// Models of fewer inliers may have rivals even where all draws will do.
  static constexpr int kManyInliers = 100;

  const LoopOptions options_;
  const Policies<Scorer, Optimizer, Rule, Refiner> policies_;
  BestHypotheses<Model, Scorer> best_;
  BestHypotheses<Model, Scorer> starts_;  ///< Draws, as they were solved.
  HypothesisBlock<Model, Scorer> block_;
  /// The best score of a draw before it is improved, what the next draw to be improved must exceed. Were it the best
  /// score of all, an improved model's, hardly any draw after the first improvement would do (PoseLib,
  /// robust/ransac_impl.h, keeps the two apart).
  double best_minimal_ = -1.0;
  bool sure_ = false;       ///< All draws will do, and other starts are not asked for.
  bool settled_ = false;    ///< Nor are other candidates.
  std::vector<int> sets_;   ///< Those that were taken.
  ConsensusResult result_;  ///< What is known of it so far.
};

/// The best model of `points` by these policies. given: models to score along with the drawn ones; they come first,
/// which makes a good one save work, and count as no draws. Status kNoModel where none was found. The result is the
/// same bit for bit for any number of threads and any block size.
template <MinimalModel Model, ScorerOf<Model> Scorer, OptimizerOf<Model> Optimizer, StoppingOf Rule,
          RefinerOf<Model> Refiner>
ConsensusResult Search(const PointMatrix& points, const Policies<Scorer, Optimizer, Rule, Refiner>& policies,
                       const LoopOptions& options, std::span<const typename Model::Parameters> given = {}) {
  Loop<Model, Scorer, Optimizer, Rule, Refiner> loop(points, policies, options);
  for (const auto& model : given) loop.Consider(model);
  loop.Draw();
  return loop.Finish();
}

}  // namespace diffsac::ransac
