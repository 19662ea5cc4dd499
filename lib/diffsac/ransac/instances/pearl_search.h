#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "diffsac/ransac/instances/instances.h"
#include "diffsac/ransac/instances/label_energy.h"
#include "diffsac/ransac/model_hooks.h"
#include "diffsac/ransac/samplers/neighbor_index.h"

namespace diffsac {

/// Several models at once, by the energy of all labels (LabelEnergy): models are added, refitted, merged and removed
/// while that lowers it, and new hypotheses are drawn within the instances found. The cost of a residual r is
///   D(r) = log(1 + (r / c ε)²) / log(1 + (R / c)²) for r ≤ R ε, c = options.core, R = options.reach:
/// from 0 to 1, and none is farther away.
/// An outlier costs options.outlier_cost; of matches options.support_weight times the log-odds that the match is right
/// by its neighbours (NeighborhoodSupport, limited to ± kMostSupport) are added.
template <MinimalModel Model>
class PearlSearch {
 public:
  using Parameters = typename Model::Parameters;
  struct Found {
    std::vector<ModelParameters> models;
    LabelEnergy::Labels labels;  ///< 0 or k for models[k − 1].
    int fits = 0;
  };

  PearlSearch(const PointMatrix& points, double threshold, const InstanceSearchOptions& options, const Rng& rng)
      : points_(points),
        threshold_(threshold),
        options_(options),
        rng_(rng),
        likely_(LikelyRows(points, &support_)),
        near_(points(likely_, Eigen::all)),
        energy_(points, options.neighbors, options.spatial_weight, options.instance_cost, OutlierCosts()) {}

  /// Points that may be of an instance, ascending: those whose neighbours speak for them, or all. Sets should be drawn
  /// from these.
  const std::vector<int>& likely() const { return likely_; }

  /// hypotheses: models, each with the rows of the set that it was solved from; none, where it comes from elsewhere.
  Found Run(const std::vector<std::pair<Parameters, std::vector<int>>>& hypotheses) {
    for (const auto& [model, set] : hypotheses) AddToPool(model, set.empty() ? likely_ : Around(set));
    State state;
    state.labels.assign(static_cast<std::size_t>(points_.rows()), 0);
    state.energy = energy_.Value(state.costs, state.labels);
    while (Add(&state)) {
    }
    Refit(&state);
    for (int round = 0; round < options_.rounds; ++round) {
      const double before = state.energy;
      DrawWithin(state, rng_.Fork("within", round));
      while (Add(&state)) Refit(&state);
      Merge(&state);
      Remove(&state);
      Refit(&state);
      if (!Lower(state.energy, before)) break;
    }
    found_.labels = state.labels;
    for (const Parameters& model : state.models) found_.models.emplace_back(model);
    return std::move(found_);
  }

 private:
  static constexpr int kSupportNeighbors = 10;
  static constexpr double kMostSupport = 3.0;
  static constexpr int kMostAround = 60;   ///< Nearest likely points to which a hypothesis is fitted first, at most.
  static constexpr int kTried = 25;        ///< Hypotheses of which the energy is looked at, for each that is added.
  static constexpr double kAlike = 0.8;    ///< Hypotheses with so large a share of common points are one.
  static constexpr int kDrawnWithin = 30;  ///< Sets that are drawn within each instance in a round.
  static constexpr double kFar = 1e4;      ///< The cost of a residual beyond R ε: none takes it.
  static constexpr double kLeastGain = 1e-6;

  /// Labels k belong to models[k − 1].
  struct State {
    std::vector<Parameters> models;
    LabelEnergy::ModelCosts costs;
    LabelEnergy::Labels labels;
    double energy = 0.0;
  };

  static bool Lower(double energy, double than) { return energy < than - kLeastGain; }

  std::vector<int> LikelyRows(const PointMatrix& points, Eigen::VectorXd* support) const {
    if (points.cols() == 4 && options_.support_weight > 0.0) *support = NeighborhoodSupport(points, kSupportNeighbors);
    std::vector<int> rows(static_cast<std::size_t>(points.rows()));
    std::iota(rows.begin(), rows.end(), 0);
    if (support->size() == 0) return rows;
    std::erase_if(rows, [&](int i) { return !((*support)[i] > 0.0); });
    if (static_cast<int>(rows.size()) > Model::kMinimalSize) return rows;
    rows.resize(static_cast<std::size_t>(points.rows()));
    std::iota(rows.begin(), rows.end(), 0);
    return rows;
  }

  Eigen::VectorXd OutlierCosts() const {
    Eigen::VectorXd costs = Eigen::VectorXd::Constant(points_.rows(), options_.outlier_cost);
    if (support_.size() > 0)
      costs.array() += options_.support_weight * support_.array().min(kMostSupport).max(-kMostSupport);
    return costs;
  }

  double CostOf(double residual) const {
    const auto rise = [&](double t) { return std::log1p(t * t / (options_.core * options_.core)); };
    const double t = residual / threshold_;
    return t <= options_.reach ? rise(t) / rise(options_.reach) : kFar;
  }

  double ResidualOf(const Parameters& model, int row) const {
    return Model::Residual(model, points_.data() + row * points_.cols());
  }

  Eigen::VectorXd CostsOf(const Parameters& model) const {
    Eigen::VectorXd costs(points_.rows());
    for (int i = 0; i < static_cast<int>(costs.size()); ++i) costs[i] = CostOf(ResidualOf(model, i));
    return costs;
  }

  double CostOf(const Parameters& model, const std::vector<int>& rows) const {
    double cost = 0.0;
    for (const int i : rows) cost += CostOf(ResidualOf(model, i));
    return cost;
  }

  /// Likely points around a set: about twice as many as are no farther from its first point than the others.
  std::vector<int> Around(const std::vector<int>& set) const {
    std::vector<int> around = near_.NearestTo(points_.data() + set[0] * points_.cols(), kMostAround);
    for (int& i : around) i = likely_[i];
    std::size_t reach = 0;
    for (std::size_t n = 0; n < around.size(); ++n)
      if (std::find(set.begin(), set.end(), around[n]) != set.end()) reach = n + 1;
    around.resize(std::min(around.size(), 2 * reach));
    return around;
  }

  static std::vector<int> RowsOf(const State& state, std::int32_t label) {
    std::vector<int> rows;
    for (std::size_t i = 0; i < state.labels.size(); ++i)
      if (state.labels[i] == label) rows.push_back(static_cast<int>(i));
    return rows;
  }

  void AddToPool(Parameters model, const std::vector<int>& region) {
    constexpr int kFits = 3;
    std::vector<int> inside;
    for (int fit = 0; fit < kFits; ++fit) {
      inside.clear();
      for (const int i : region)
        if (ResidualOf(model, i) <= threshold_) inside.push_back(i);
      if (static_cast<int>(inside.size()) <= Model::kMinimalSize) break;
      Parameters fitted = model;
      ++found_.fits;
      if (!FitAgain<Model>(points_(inside, Eigen::all), Eigen::VectorXd::Ones(inside.size()), &fitted) ||
          !fitted.allFinite())
        break;
      model = fitted;
    }
    pool_.push_back({model, CostsOf(model)});
  }

  /// The model of these rows by least squares and by a robust refinement, from *model where `from` says so, else anew.
  /// False where they determine none.
  bool FitRows(const std::vector<int>& rows, bool from, Parameters* model) {
    if (static_cast<int>(rows.size()) <= Model::kMinimalSize) return false;
    const PointMatrix some = points_(rows, Eigen::all);
    const Eigen::VectorXd weights = Eigen::VectorXd::Ones(some.rows());
    Parameters fitted = *model;
    ++found_.fits;
    if ((!from && !Model::Fit(some, weights, &fitted)) || !fitted.allFinite()) return false;
    const RobustLoss loss{LossKind::kCauchy, options_.core * threshold_};
    if constexpr (HasRobustRefine<Model>)
      Model::Refine(some, weights, loss, &fitted, kRefineSteps);
    else
      Reweight(some, loss, &fitted);
    if (!fitted.allFinite()) return false;
    *model = fitted;
    return true;
  }
  static constexpr int kRefineSteps = 10;

  static void Reweight(const PointMatrix& points, const RobustLoss& loss, Parameters* model) {
    Eigen::VectorXd weights(points.rows());
    for (int step = 0; step < kRefineSteps; ++step) {
      for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double r = Model::Residual(*model, points.data() + i * points.cols());
        weights[i] = loss.Weight(r * r);
      }
      if (!FitAgain<Model>(points, weights, model)) return;
    }
  }

  void SetModel(std::size_t k, const Parameters& model, State* state) const {
    state->models[k] = model;
    state->costs[k] = CostsOf(model);
  }

  /// Expansions of all labels; models without points are dropped.
  void Settle(State* state) const {
    energy_.ExpandAll(state->costs, &state->labels);
    DropUnused(state);
    state->energy = energy_.Value(state->costs, state->labels);
  }

  static void DropUnused(State* state) {
    std::vector<std::int32_t> place(state->models.size() + 1, 0);
    for (const std::int32_t label : state->labels) place[label] = 1;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < state->models.size(); ++k) {
      if (place[k + 1] == 0) continue;
      state->models[kept] = state->models[k];
      if (kept != k) state->costs[kept] = std::move(state->costs[k]);
      place[k + 1] = static_cast<std::int32_t>(++kept);
    }
    place[0] = 0;
    state->models.resize(kept);
    state->costs.resize(kept);
    for (std::int32_t& label : state->labels) label = place[label];
  }

  /// Each model refitted to its points, and points given anew, while the energy falls.
  void Refit(State* state) {
    constexpr int kRefits = 3;
    for (int refit = 0; refit < kRefits; ++refit) {
      State next = *state;
      for (std::size_t k = 0; k < next.models.size(); ++k) RefitModel(k, &next);
      Settle(&next);
      if (!Lower(next.energy, state->energy)) return;
      *state = std::move(next);
    }
  }

  void RefitModel(std::size_t k, State* state) {
    const std::vector<int> rows = RowsOf(*state, static_cast<std::int32_t>(k + 1));
    double least = CostOf(state->models[k], rows);
    for (const bool from : {true, false}) {
      Parameters model = state->models[k];
      if (!FitRows(rows, from, &model)) continue;
      const double cost = CostOf(model, rows);
      if (!(cost < least)) continue;
      least = cost;
      SetModel(k, model, state);
    }
  }

  /// Takes the hypothesis of the pool with which the energy is least, if that is less than without it.
  bool Add(State* state) {
    if (static_cast<int>(state->models.size()) >= options_.most) return false;
    State best = *state;
    for (const std::size_t h : Promising(*state)) {
      State next = *state;
      next.models.push_back(pool_[h].model);
      next.costs.push_back(pool_[h].costs);
      const auto label = static_cast<std::int32_t>(next.models.size());
      energy_.Expand(next.costs, label, &next.labels);
      next.energy = energy_.Value(next.costs, next.labels);
      if (!(next.energy < state->energy + options_.instance_cost)) continue;
      State refitted = next;
      RefitModel(refitted.models.size() - 1, &refitted);
      energy_.Expand(refitted.costs, label, &refitted.labels);
      refitted.energy = energy_.Value(refitted.costs, refitted.labels);
      if (refitted.energy < next.energy) next = std::move(refitted);
      if (Lower(next.energy, best.energy)) best = std::move(next);
    }
    if (!Lower(best.energy, state->energy)) return false;
    *state = std::move(best);
    DropUnused(state);
    return true;
  }

  /// The hypotheses that could save most were there no neighbours, most first, none of them alike.
  std::vector<std::size_t> Promising(const State& state) const {
    Eigen::VectorXd now(points_.rows());
    for (Eigen::Index i = 0; i < now.size(); ++i) now[i] = energy_.PointCost(state.costs, state.labels[i], i);
    std::vector<std::pair<double, std::size_t>> gains;
    for (std::size_t h = 0; h < pool_.size(); ++h) {
      const double gain = (now - pool_[h].costs).cwiseMax(0.0).sum();
      if (gain > options_.instance_cost) gains.emplace_back(gain, h);
    }
    std::stable_sort(gains.begin(), gains.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<std::size_t> chosen;
    for (const auto& [gain, h] : gains) {
      if (static_cast<int>(chosen.size()) == kTried) break;
      if (std::none_of(chosen.begin(), chosen.end(), [&, h = h](std::size_t other) { return Alike(h, other); }))
        chosen.push_back(h);
    }
    return chosen;
  }

  bool Alike(std::size_t a, std::size_t b) const {
    const double near = CostOf(threshold_);
    const auto first = pool_[a].costs.array() < near, second = pool_[b].costs.array() < near;
    return static_cast<double>((first && second).count()) > kAlike * static_cast<double>((first || second).count());
  }

  /// One model for two, of the two for which that lowers the energy most.
  void Merge(State* state) {
    State best = *state;
    const auto count = static_cast<std::int32_t>(state->models.size());
    for (std::int32_t a = 1; a <= count; ++a)
      for (std::int32_t b = a + 1; b <= count; ++b) {
        State next = *state;
        for (std::int32_t& label : next.labels) label = label == b ? a : label;
        Parameters model = next.models[a - 1];
        if (!FitRows(RowsOf(next, a), false, &model)) continue;
        SetModel(static_cast<std::size_t>(a - 1), model, &next);
        DropUnused(&next);
        Settle(&next);
        if (next.energy < state->energy + options_.instance_cost) Refit(&next);
        if (Lower(next.energy, best.energy)) best = std::move(next);
      }
    *state = std::move(best);
  }

  /// One model less, if that lowers the energy.
  void Remove(State* state) {
    State best = *state;
    for (std::int32_t k = 1; k <= static_cast<std::int32_t>(state->models.size()); ++k) {
      State next = *state;
      for (std::int32_t& label : next.labels) label = label == k ? 0 : label;
      DropUnused(&next);
      Settle(&next);
      if (Lower(next.energy, best.energy)) best = std::move(next);
    }
    *state = std::move(best);
  }

  void DrawWithin(const State& state, const Rng& rng) {
    for (std::size_t k = 0; k < state.models.size(); ++k) {
      const std::vector<int> rows = RowsOf(state, static_cast<std::int32_t>(k + 1));
      if (static_cast<int>(rows.size()) <= Model::kMinimalSize) continue;
      Rng draw = rng.Fork("structure", k);
      for (int n = 0; n < kDrawnWithin; ++n) {
        int set[Model::kMinimalSize];
        Parameters models[Model::kMaxSolutions];
        draw.Distinct(static_cast<int>(rows.size()), Model::kMinimalSize, set);
        for (int& i : set) i = rows[i];
        const int solutions = Model::SolveMinimal(points_, set, models);
        found_.fits += std::max(1, solutions);
        for (int i = 0; i < solutions; ++i)
          if (models[i].allFinite()) AddToPool(models[i], rows);
      }
    }
  }

  struct Hypothesis {
    Parameters model;
    Eigen::VectorXd costs;
  };

  const PointMatrix& points_;
  const double threshold_;
  const InstanceSearchOptions& options_;
  const Rng rng_;
  Eigen::VectorXd support_;  ///< Empty where there is none.
  std::vector<int> likely_;
  NeighborIndex near_;  ///< Of the likely points.
  LabelEnergy energy_;
  std::vector<Hypothesis> pool_;
  Found found_;
};

}  // namespace diffsac
