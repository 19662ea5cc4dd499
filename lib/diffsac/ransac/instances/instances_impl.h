#pragma once

// The search behind instances.h, for the files that instantiate it for a model.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>
#include <numeric>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/hyperplane.h"
#include "diffsac/geometry/point_spread.h"
#include "diffsac/ransac/instances/instances.h"
#include "diffsac/ransac/instances/pearl_search.h"
#include "diffsac/ransac/model_hooks.h"
#include "diffsac/ransac/scores/noise_scales.h"
#include "diffsac/ransac/scores/number_of_false_alarms.h"

namespace diffsac {

namespace instances_internal {

/// Uniform points that say how often one fits a model by chance.
inline constexpr int kChancePoints = 10000;
/// Beside a model: farther than ε, in a space so many times as large.
inline constexpr double kBeside = 12.0;
/// An instance is so many times as dense as what is beside it; the best model of a cluster is not.
inline constexpr double kDenser = 3.0;
/// A model of whose points so large a share is near other models, in a space so many times as large as that within ε,
/// is one of them, seen twice: real surfaces are thicker than ε. Not where a gap parts them
/// (StructuresSearch::IsApart).
inline constexpr double kNear = 3.0;
inline constexpr double kSame = 0.7;
/// In the gap between two surfaces the points are so many times less dense than on the lesser one, beyond chance; so
/// large a share of that one's points is on one side of the other, beyond ε and no farther than points near it reach.
inline constexpr double kSparser = 2.0;
inline constexpr double kAlongside = 0.9;

/// Lines and planes.
template <class Model>
concept IsHyperplane = std::same_as<Model, Hyperplane<Model::kDimension>>;

/// How many ε a space so many times as large as that within ε reaches: a residual in the image plane has two
/// dimensions.
template <MinimalModel Model>
double Reach(double times) {
  return std::pow(times, 1.0 / ResidualDimension<Model>());
}

/// What speaks for a model, among free points and its own.
struct InstanceSupport {
  int points = 0;
  int inside = 0;  ///< Within ε.
  int beside = 0;
  int shared = 0;  ///< Of those inside, how many are near other models.
  bool IsSame() const { return shared >= kSame * inside; }
  bool IsDense() const { return (kBeside - 1.0) * inside > kDenser * beside; }
};

/// Where points of no instance might be: of matches, uniform points in the box of the data.
template <MinimalModel Model>
class ChanceSpace {
 public:
  ChanceSpace(const PointMatrix& points, double threshold, Rng rng)
      : threshold_(threshold), uniform_(kChancePoints, points.cols()) {
    const Eigen::RowVectorXd low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    for (Eigen::Index i = 0; i < kChancePoints; ++i)
      for (Eigen::Index k = 0; k < points.cols(); ++k) uniform_(i, k) = rng.Uniform(low[k], high[k]);
  }

  /// Which share of them fits a model.
  double ShareNear(const ModelParameters& parameters) const {
    const typename Model::Parameters model = parameters;
    int fitting = 0;
    for (Eigen::Index i = 0; i < kChancePoints; ++i)
      fitting += Model::Residual(model, uniform_.data() + i * uniform_.cols()) <= threshold_;
    return (fitting + 1.0) / (kChancePoints + 1.0);
  }

 private:
  double threshold_;
  PointMatrix uniform_;
};

/// Of lines and planes, the ellipsoid in which uniform points have the data's covariance: it turns with the data. It
/// reaches kBeside thresholds however flat the data is, that of one plane, say. Its section by the model counts, and
/// half of its largest one at least: data of another shape goes on where the ellipsoid ends.
template <MinimalModel Model>
requires IsHyperplane<Model>
class ChanceSpace<Model> {
 public:
  ChanceSpace(const PointMatrix& points, double threshold, const Rng&)
      : threshold_(threshold), spread_(SpreadOf(points)) {}

  double ShareNear(const ModelParameters& model) const {
    constexpr int kDimension = Model::kDimension;
    const Eigen::VectorXd along = spread_.axes.transpose() * model.head(kDimension);
    const double sigma = along.cwiseProduct(spread_.sides).norm() / std::sqrt(12.0);
    const double reach = std::max(std::sqrt(kDimension + 2.0) * sigma, kBeside * threshold_);
    const double place = std::abs(model.head(kDimension).dot(spread_.centre) + model[kDimension]) / reach;
    const double half = threshold_ / reach;
    return std::max(ShareBelow(place + half) - ShareBelow(place - half), 0.5 * (ShareBelow(half) - ShareBelow(-half)));
  }

 private:
  /// Of a disc or a ball of radius 1, what is below this height.
  static double ShareBelow(double height) {
    const double h = std::clamp(height, -1.0, 1.0);
    if constexpr (Model::kDimension == 2) return 0.5 + (h * std::sqrt(1.0 - h * h) + std::asin(h)) / std::numbers::pi;
    return 0.5 + 0.25 * h * (3.0 - h * h);
  }

  double threshold_;
  PointSpread spread_;
};

/// log10 of the number of such models (LogChanceModels) that points of no instance would give. least: of a point that
/// fits, the least probability.
template <MinimalModel Model>
double LogModels(const ChanceSpace<Model>& chance, const ModelParameters& model, int points, int inside, double least) {
  return LogChanceModels(points, inside, Model::kMinimalSize, std::max(least, chance.ShareNear(model)));
}

/// So many models that are no instance are passed over before the search ends.
inline constexpr int kMostAside = 20;

/// What is known of some of the points.
inline EstimationPriors OfRows(const EstimationPriors& priors, const std::vector<int>& rows) {
  EstimationPriors some = priors;
  // A list that is not one number a point is left as it is, for the loop to pass over.
  const auto fits = [&](const Eigen::VectorXd& values) { return rows.empty() || values.size() > rows.back(); };
  if (fits(priors.inlier_priors)) some.inlier_priors = priors.inlier_priors(rows);
  if (!rows.empty() && priors.turns.rows() > rows.back()) some.turns = priors.turns(rows, Eigen::all);
  if (fits(priors.fit_weights)) some.fit_weights = priors.fit_weights(rows);
  return some;
}

template <MinimalModel Model>
class InstancesSearch {
 public:
  using Parameters = typename Model::Parameters;

  InstancesSearch(const PointMatrix& points, double threshold, const SamplerOfRows& sampler_of,
                  const ConsensusOptions& options, const InstanceSearchOptions& instances, const Rng& rng,
                  const EstimationPriors& priors)
      : points_(points),
        threshold_(threshold),
        source_of_(sampler_of),
        options_(options),
        instances_(instances),
        rng_(rng),
        priors_(priors),
        chance_(points, threshold, rng.Fork("chance")) {
    // As the loop does, which other searches do without.
    std::erase_if(priors_.models, [](const ModelParameters& model) {
      return model.size() != Parameters::SizeAtCompileTime || !model.allFinite();
    });
  }

  InstancesResult Run() {
    found_.assignment.assign(static_cast<std::size_t>(points_.rows()), 0);
    aside_.assign(found_.assignment.size(), 0);
    switch (instances_.search) {
      case InstanceSearch::kChosen:
        Solve();
        return Chosen();
      case InstanceSearch::kPearl:
        ByPearl();
        Finish();
        return std::move(found_);
      case InstanceSearch::kAtOnce:
        Solve();
        TakeOneByOne();
        break;
      default:
        TakeOneByOne();
    }
    for (int round = 0; round < instances_.rounds && !models_.empty(); ++round) RefitAll(round);
    Assign();
    DropChance();
    Finish();
    return std::move(found_);
  }

 private:
  static std::vector<int> AllRows(Eigen::Index count) {
    std::vector<int> rows(static_cast<std::size_t>(count));
    std::iota(rows.begin(), rows.end(), 0);
    return rows;
  }

  std::vector<int> RowsOf(std::int32_t label) const {
    std::vector<int> rows;
    for (int i = 0; i < static_cast<int>(found_.assignment.size()); ++i)
      if (found_.assignment[i] == label) rows.push_back(i);
    return rows;
  }

  /// All hypotheses, before any is chosen.
  void Solve() {
    SolveSets(AllRows(points_.rows()),
              [&](const Parameters& model, const int*) { priors_.models.emplace_back(model); });
  }

  /// Sets of these rows; `take` gets each finite model and its set.
  template <class Take>
  void SolveSets(const std::vector<int>& rows, const Take& take) {
    const auto sampler = source_of_(rows, 0);
    std::vector<int> sets = DrawSets(*sampler, Model::kMinimalSize, options_.max_iterations);
    for (int& i : sets) i = i >= 0 && i < static_cast<int>(rows.size()) ? rows[i] : -1;
    Parameters models[Model::kMaxSolutions];
    for (std::size_t first = 0; first < sets.size(); first += Model::kMinimalSize) {
      const int solutions = SolveSet<Model>(points_, sets.data() + first, models);
      found_.hypotheses += std::max(1, solutions);
      for (int i = 0; i < solutions; ++i)
        if (models[i].allFinite()) take(models[i], sets.data() + first);
    }
    found_.iterations = static_cast<std::int64_t>(sets.size()) / Model::kMinimalSize;
    found_.unique_minimal_sets = CountUniqueSets(sets, Model::kMinimalSize);
    found_.first_sets = FirstSets(sets, Model::kMinimalSize);
  }

  void ByPearl() {
    PearlSearch<Model> search(points_, threshold_, instances_, rng_.Fork("energy"));
    std::vector<std::pair<Parameters, std::vector<int>>> hypotheses;
    for (const ModelParameters& model : priors_.models) hypotheses.emplace_back(Parameters(model), std::vector<int>());
    SolveSets(search.likely(), [&](const Parameters& model, const int* set) {
      hypotheses.emplace_back(model, std::vector<int>(set, set + Model::kMinimalSize));
    });
    auto found = search.Run(hypotheses);
    found_.hypotheses += found.fits;
    models_ = std::move(found.models);
    found_.assignment = std::move(found.labels);
  }

  InstancesResult Chosen() {
    if (instances_.chosen_by == nullptr) return std::move(found_);
    ChosenInstances chosen = instances_.chosen_by->Choose(points_, priors_.point_weights, priors_.models,
                                                          instances_.most, instances_.least_value);
    models_ = std::move(chosen.models);
    found_.values = std::move(chosen.values);
    Assign();
    found_.models = models_;
    found_.status = models_.empty() ? Status::kNoModel : Status::kOk;
    return std::move(found_);
  }

  /// One search on some of the points. draw: with sets of its own, else of the hypotheses that are known.
  ConsensusResult Search(const std::vector<int>& rows, const EstimationPriors& priors, bool draw, const Rng& rng) {
    const PointMatrix some = points_(rows, Eigen::all);
    PrecomputedSampler none({});
    std::unique_ptr<MinimalSampler> own;
    if (draw) own = source_of_(rows, searches_++);
    ConsensusResult result = SampleConsensus<Model>(some, threshold_, own ? *own : none, options_, rng, priors);
    found_.hypotheses += result.hypotheses;
    if (!draw) return result;
    found_.iterations += result.iterations;
    found_.unique_minimal_sets += result.unique_minimal_sets;
    for (std::vector<int>& set : result.first_sets) {
      if (found_.first_sets.size() == kReportedSets) break;
      if (!AreRows(set, some.rows())) continue;  // A sampler may name points that there are none of.
      for (int& i : set) i = rows[i];
      found_.first_sets.push_back(std::move(set));
    }
    return result;
  }

  /// A model that is no instance, the best there is in a cluster or in the tail of a thick wall, hides smaller ones:
  /// its points are set aside.
  void TakeOneByOne() {
    const bool draw = instances_.search == InstanceSearch::kSequential;
    int asides = 0;
    while (static_cast<int>(models_.size()) < instances_.most && asides <= kMostAside) {
      std::vector<int> left = RowsOf(0);
      std::erase_if(left, [&](int i) { return aside_[i] != 0; });
      if (static_cast<int>(left.size()) <= Model::kMinimalSize) return;
      const ConsensusResult best =
          Search(left, OfRows(priors_, left), draw, rng_.Fork("structure", models_.size() + asides));
      if (draw) priors_.models.clear();
      if (best.status != Status::kOk) return;
      const auto inliers = static_cast<int>(std::count(best.inliers.begin(), best.inliers.end(), 1));
      // Not even by uniform points: there is nothing any more.
      if (IsChance(best.model, static_cast<int>(left.size()), inliers)) return;
      const bool instance = IsInstance(best.model, SupportOf(best.model, kCandidate));
      if (instance) models_.push_back(best.model);
      for (std::size_t i = 0; i < left.size(); ++i) {
        if (best.inliers[i] == 0) continue;
        if (instance)
          found_.assignment[left[i]] = static_cast<std::int32_t>(models_.size());
        else
          aside_[left[i]] = 1;
      }
      if (!instance) ++asides;
    }
  }

  /// The model of these points alone, from `start` (null: from least squares). False where there is none.
  bool Refit(const std::vector<int>& rows, const ModelParameters* start, const Rng& rng, ModelParameters* model) {
    EstimationPriors own = OfRows(priors_, rows);
    own.models.clear();
    if (start != nullptr) own.models.push_back(*start);
    own.fit_weights = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(rows.size()));
    const ConsensusResult result = Search(rows, own, false, rng);
    if (result.status != Status::kOk) return false;
    *model = result.model;
    return true;
  }

  void RefitAll(int round) {
    Assign();
    for (std::size_t k = 0; k < models_.size(); ++k) {
      const std::vector<int> rows = RowsOf(static_cast<std::int32_t>(k + 1));
      if (static_cast<int>(rows.size()) <= Model::kMinimalSize) continue;
      Refit(rows, &models_[k], rng_.Fork("refit", round).Fork("model", k), &models_[k]);
    }
  }

  /// Each point to the model that it is nearest to, none farther than ε.
  void Assign() {
    for (Eigen::Index i = 0; i < points_.rows(); ++i) {
      double least = threshold_;
      found_.assignment[i] = 0;
      for (std::size_t k = 0; k < models_.size(); ++k) {
        const double r = Model::Residual(Parameters(models_[k]), points_.data() + i * points_.cols());
        const bool nearer = found_.assignment[i] == 0 ? r <= least : r < least;
        if (!nearer) continue;
        least = r;
        found_.assignment[i] = static_cast<std::int32_t>(k + 1);
      }
    }
  }

  /// Leaves out the models whose own points chance would give, or that are another one of more points, that of fewest
  /// points first.
  void DropChance() {
    for (;;) {
      std::size_t fewest = 0, points = 0;
      bool drop = false;
      for (std::size_t k = 0; k < models_.size(); ++k) {
        if (IsInstance(models_[k], SupportOf(models_[k], static_cast<int>(k)))) continue;
        const std::size_t own = RowsOf(static_cast<std::int32_t>(k + 1)).size();
        if (!drop || own < points) fewest = k, points = own;
        drop = true;
      }
      if (!drop) return;
      models_.erase(models_.begin() + static_cast<std::ptrdiff_t>(fewest));
      Assign();
    }
  }

  void Finish() {
    std::vector<double> sizes(models_.size() + 1, 0.0);
    std::vector<std::size_t> order(models_.size());
    const bool weighted = priors_.point_weights.size() == points_.rows();
    for (std::size_t i = 0; i < found_.assignment.size(); ++i)
      sizes[found_.assignment[i]] += weighted ? priors_.point_weights[static_cast<Eigen::Index>(i)] : 1.0;
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return sizes[a + 1] > sizes[b + 1]; });
    std::vector<std::int32_t> place(models_.size() + 1, 0);
    for (std::size_t k = 0; k < order.size(); ++k) {
      found_.models.push_back(models_[order[k]]);
      place[order[k] + 1] = static_cast<std::int32_t>(k + 1);
    }
    for (std::int32_t& label : found_.assignment) label = place[label];
    found_.status = models_.empty() ? Status::kNoModel : Status::kOk;
  }

  double ResidualOf(const ModelParameters& model, Eigen::Index row) const {
    return Model::Residual(Parameters(model), points_.data() + row * points_.cols());
  }

  /// The models that a model must be clear of: for a candidate all, for one that was taken those of more points.
  std::vector<std::size_t> Above(int k) const {
    std::vector<std::size_t> above;
    const std::size_t own = k == kCandidate ? 0 : RowsOf(k + 1).size();
    for (std::size_t j = 0; j < models_.size(); ++j)
      if (k == kCandidate || (static_cast<int>(j) != k && RowsOf(static_cast<std::int32_t>(j + 1)).size() > own))
        above.push_back(j);
    return above;
  }

  /// k: the model's place, or kCandidate.
  InstanceSupport SupportOf(const ModelParameters& model, int k) const {
    InstanceSupport support;
    std::vector<int> inside;
    for (int i = 0; i < static_cast<int>(points_.rows()); ++i) {
      const std::int32_t label = found_.assignment[i];
      if (label != 0 && label != k + 1) continue;
      const double r = ResidualOf(model, i);
      ++support.points;
      // Of a candidate, points set aside were another's: they are background.
      if (r <= threshold_ && (k != kCandidate || aside_[i] == 0)) inside.push_back(i);
      support.beside += r > threshold_ && r <= Reach<Model>(kBeside) * threshold_;
    }
    support.inside = static_cast<int>(inside.size());
    std::vector<std::size_t> above = Above(k);
    support.shared = CountShared(inside, above);
    if (!support.IsSame()) return support;
    std::erase_if(above, [&](std::size_t j) { return IsApart(model, models_[j]); });
    support.shared = CountShared(inside, above);
    return support;
  }

  int CountShared(const std::vector<int>& inside, const std::vector<std::size_t>& above) const {
    return static_cast<int>(std::count_if(inside.begin(), inside.end(), [&](int i) {
      return std::any_of(above.begin(), above.end(),
                         [&](std::size_t j) { return ResidualOf(models_[j], i) <= Reach<Model>(kNear) * threshold_; });
    }));
  }

  /// Whether a line or plane is another surface than the greater one, as the sides of a thin wall are: it lies beside
  /// it, and of all points hardly any is in a layer halfway between the two, where those of one thick surface are
  /// denser than in such a layer about the lesser.
  bool IsApart(const ModelParameters& lesser, const ModelParameters& greater) const {
    if constexpr (IsHyperplane<Model>) {
      constexpr int kDimension = Model::kDimension;
      const double side = lesser.head(kDimension).dot(greater.head(kDimension)) < 0.0 ? -1.0 : 1.0;
      const double layer = 0.5 * threshold_, reach = (kNear + 1.0) * threshold_;
      int inside = 0, left = 0, right = 0, middle = 0, between = 0;
      for (Eigen::Index i = 0; i < points_.rows(); ++i) {
        const double to_lesser = side * (points_.row(i).dot(lesser.head(kDimension)) + lesser[kDimension]);
        const double to_greater = points_.row(i).dot(greater.head(kDimension)) + greater[kDimension];
        const bool is_inside = std::abs(to_lesser) <= threshold_, is_near = std::abs(to_greater) <= reach;
        inside += is_inside;
        left += is_inside && is_near && to_greater < -threshold_;
        right += is_inside && is_near && to_greater > threshold_;
        middle += std::abs(to_lesser) <= 0.5 * layer;
        between += to_lesser * to_greater < 0.0 && std::abs(to_lesser + to_greater) <= layer;
      }
      return std::max(left, right) >= kAlongside * inside &&
             kSparser * (between + 2.0 * std::sqrt(between + 1.0)) < middle;
    }
    return false;
  }

  bool IsChance(const ModelParameters& model, int points, int inside) const {
    return !(LogModels(chance_, model, points, inside, instances_.least_chance) < instances_.log10_nfa);
  }

  bool IsInstance(const ModelParameters& model, const InstanceSupport& support) const {
    return !support.IsSame() && !IsChance(model, support.points, support.inside) && support.IsDense();
  }

  static constexpr int kCandidate = -1;

  const PointMatrix& points_;
  const double threshold_;
  const SamplerOfRows& source_of_;
  const ConsensusOptions& options_;
  const InstanceSearchOptions& instances_;
  const Rng rng_;
  EstimationPriors priors_;  ///< With the hypotheses that are known.
  ChanceSpace<Model> chance_;
  int searches_ = 0;
  std::vector<std::uint8_t> aside_;  ///< 1 for points of models that are no instance.
  std::vector<ModelParameters> models_;
  InstancesResult found_;
};

}  // namespace instances_internal

template <MinimalModel Model>
InstancesResult FindInstances(const PointMatrix& points, double inlier_threshold, const SamplerOfRows& sampler_of,
                              const ConsensusOptions& options, const InstanceSearchOptions& instances, const Rng& rng,
                              const EstimationPriors& priors) {
  InstancesResult failed;
  failed.status = CheckPoints<Model>(points);
  if (failed.status != Status::kOk) return failed;
  failed.status = Status::kNoModel;
  if (!(inlier_threshold >= kLeastScale && inlier_threshold <= kLargestScale)) return failed;
  return instances_internal::InstancesSearch<Model>(points, inlier_threshold, sampler_of, options, instances, rng,
                                                    priors)
      .Run();
}

}  // namespace diffsac
