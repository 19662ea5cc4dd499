#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <vector>

#include "diffsac/geometry/model.h"
#include "diffsac/ransac/best_hypotheses.h"
#include "diffsac/ransac/consensus_result.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac {

/// A model with its score.
template <MinimalModel Model>
struct ScoredModel {
  typename Model::Parameters model;
  double score;
};

namespace ransac {

// A search (loop.h) is a model and five policies. Any type that has the members below can take the place of the
// library's own, which the right column names. Policies are asked in the order of the draws and by one thread, but for
// the scorer, which several threads ask at once.
//
//   policy    what it decides                                     the library's own
//   sampler   which points are drawn together                     samplers/: uniform, PROSAC, NAPSAC, by weights, ...
//   scorer    which of two models is better                       scores/scorer.h with one of scores/score.h
//   optimize  what becomes of a draw that is the best so far      local/local_optimizer.h
//   stop      when there are draws enough                         stopping_rule.h
//   refine    which of the best models is returned, and how fine  local/final_refiner.h

/// scorer(model, score_to_beat): the score, larger is better, at least 0; anything up to `score_to_beat` where it is
/// not above `score_to_beat`. Const, and a function of its arguments alone. scorer.Residuals(model): N lengths.
template <class Scorer, class Model>
concept ScorerOf = requires(const Scorer& scorer, const typename Model::Parameters& model, double score_to_beat) {
  { scorer(model, score_to_beat) } -> std::convertible_to<double>;
  { scorer.Residuals(model) } -> std::convertible_to<Eigen::VectorXd>;
};

/// optimize(found, set, best_score, fits): the best model met on the way from `found`, itself when none scores higher.
/// set: the minimal set that it was solved from; null when it was given. best_score: of all models before it. Adds what
/// it solved or fitted to *fits. optimize.Again(model, fits): the same on another way, whatever `model` scores.
template <class Optimizer, class Model>
concept OptimizerOf = requires(Optimizer& optimize, const ScoredModel<Model>& found, const int* set, double best_score,
                               int* fits) {
  { optimize(found, set, best_score, fits) } -> std::same_as<ScoredModel<Model>>;
  { optimize.Again(found.model, fits) } -> std::same_as<ScoredModel<Model>>;
};

/// Members as StoppingRule has them.
template <class Rule>
concept StoppingOf = requires(Rule& rule, const std::vector<std::uint8_t>& inliers, std::int64_t iterations) {
  rule.SetDrawnPoints(1);
  rule.Update(inliers);
  { rule.inliers() } -> std::convertible_to<std::int64_t>;
  { rule.After(iterations) } -> std::same_as<StopReason>;
  { rule.Finds(iterations) } -> std::same_as<bool>;
};

/// refine(candidates, fits): the best of candidates (`model`, `score`; best first) after its refits, nothing without
/// any. refine.Inliers(model): a mask of the points that support a model. refine.Complete(candidates, chosen, result):
/// fills *result with what is to be said of the model that was chosen.
template <class Refiner, class Model>
concept RefinerOf = requires(const Refiner& refine, const std::vector<ScoredModel<Model>>& candidates,
                             const typename Model::Parameters& model, int* fits, ConsensusResult* result) {
  { refine(candidates, fits) } -> std::same_as<std::optional<ScoredModel<Model>>>;
  { refine.Inliers(model) } -> std::same_as<std::vector<std::uint8_t>>;
  refine.Complete(candidates, candidates.front(), result);
};

/// The policies of one search, all borrowed.
template <class Scorer, class Optimizer, class Rule, class Refiner>
struct Policies {
  MinimalSampler& sampler;
  const Scorer& scorer;
  Optimizer& optimize;
  Rule& stop;
  const Refiner& refine;
};
template <class Scorer, class Optimizer, class Rule, class Refiner>
Policies(MinimalSampler&, const Scorer&, Optimizer&, Rule&, const Refiner&)
    -> Policies<Scorer, Optimizer, Rule, Refiner>;

}  // namespace ransac
}  // namespace diffsac
