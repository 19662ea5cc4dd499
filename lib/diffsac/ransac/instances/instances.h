#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "diffsac/geometry/points.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac {

/// How several models are looked for in one point set.
///   kOne         "one": they are not; one model
///   kSequential  "sequential": one search after the other, each on the points that are left, with a sampler of its own
///   kAtOnce      "at_once": all sets are drawn and solved first; then the best hypothesis is chosen on the points that
///                are left, one after the other
///   kPearl      "pearl": of the same hypotheses those that, with labels of all points, make one energy least
///                (pearl_search.h)
///   kChosen      "chosen": of the same hypotheses a InstanceChooser takes some, in its order
enum class InstanceSearch { kOne, kSequential, kAtOnce, kChosen, kPearl };
template <>
inline constexpr auto kEnumNames<InstanceSearch> = NamesOf<InstanceSearch>({{InstanceSearch::kOne, "one"},
                                                                            {InstanceSearch::kSequential, "sequential"},
                                                                            {InstanceSearch::kAtOnce, "at_once"},
                                                                            {InstanceSearch::kChosen, "chosen"},
                                                                            {InstanceSearch::kPearl, "pearl"}});

/// Instances that were chosen, the surest first, and how sure the chooser was of each beside those before it: a
/// probability.
struct ChosenInstances {
  std::vector<ModelParameters> models;
  std::vector<double> values;
};

/// What chooses instances among hypotheses for `instances.search: chosen`, whatever drew the hypotheses.
class InstanceChooser {
 public:
  virtual ~InstanceChooser() = default;
  /// Of `hypotheses`, models of the points, those that are instances, refined, the surest first; at most `most`, and
  /// none of which the chooser is less sure than `least`, a probability. weights: of the points (PointWeights), empty
  /// where they say alike.
  virtual ChosenInstances Choose(const PointMatrix& points, const Eigen::VectorXd& weights,
                                 const std::vector<ModelParameters>& hypotheses, int most, double least) const = 0;
};

/// The group `instances` of a row.
struct InstanceSearchOptions {
  InstanceSearch search = InstanceSearch::kOne;
  int most = 20;  ///< Instances that are looked for at most.
  /// An instance is taken while chance gives fewer than 10 to this power of its like (LogChanceModels): the score that
  /// stops the search.
  double log10_nfa = 0.0;
  /// A point anywhere is within ε of a model with this probability at least. Outliers that are not uniform, correct
  /// matches of other depths say, fit by chance more often than uniform ones, from which it is otherwise reckoned.
  double least_chance = 0.0;
  /// Rounds in which each point goes to the model that it is nearest to, and each model is refitted to its points. Of
  /// kPearl: in which models are drawn within instances, added, merged and removed.
  int rounds = 2;
  // Of kPearl (pearl_search.h), in units of the cost of a point as far from its model as can be.
  double core = 0.2;             ///< c: the cost of a residual begins to rise at this share of ε.
  double reach = 6.0;            ///< R: so many ε from its model a point can be.
  double outlier_cost = 0.4;     ///< Of a point without a model.
  double support_weight = 0.35;  ///< Of what a match's neighbours say for it; 0: they are not asked.
  double instance_cost = 5.0;    ///< Of each model: so many points have to speak for it.
  double spatial_weight = 0.15;  ///< Of two neighbours with different models.
  int neighbors = 6;             ///< Nearest points, in all coordinates, that are a point's neighbours.
  std::string chooser;           ///< Of kChosen: the file of its network.
  double least_value = 0.0;      ///< Of kChosen: an instance is taken of which it is so sure.
  std::shared_ptr<const InstanceChooser> chosen_by = {};  ///< Of kChosen, by whoever read that file.
  bool Several() const { return search != InstanceSearch::kOne; }
};

/// Several models with disjoint inliers, that of most points (of most weight, where they have weights) first; of
/// kChosen the surest first.
struct InstancesResult {
  /// kNoModel, and no models: nothing that chance would not give. The points' own, where they are unfit.
  Status status = Status::kNoModel;
  std::vector<ModelParameters> models;
  std::vector<double> values;  ///< Of kChosen: how sure the chooser was of each; empty for others.
  /// N values: 0 for none, k for models[k − 1], from which it is at most ε away, of kPearl reach · ε.
  std::vector<std::int32_t> assignment;
  int hypotheses = 0;  ///< models solved or fitted, all stages
  int unique_minimal_sets = 0;
  std::int64_t iterations = 0;               ///< minimal sets drawn
  std::vector<std::vector<int>> first_sets;  ///< up to kReportedSets, in the points' rows
};

/// The minimal sets of points `rows` (ascending), as places among these; search: which one, 0 for the first.
using SamplerOfRows = std::function<std::unique_ptr<MinimalSampler>(const std::vector<int>& rows, int search)>;

/// Finds as many instances as the points have. Each choice of one model is a SampleConsensus of its own on the points
/// that are left: score, local optimisation, refit and what is known of the points (priors) act as they do there. It
/// ends with the first model that chance would give, or when too few points are left. Then points are assigned to the
/// nearest model and models refitted to their points; those that chance would then give are left out.
///
/// options.max_iterations: sets that are drawn, of `sequential` for each search. priors.models join the hypotheses of
/// the first search, or of all points.
template <MinimalModel Model>
InstancesResult FindInstances(const PointMatrix& points, double inlier_threshold, const SamplerOfRows& sampler_of,
                              const ConsensusOptions& options, const InstanceSearchOptions& instances, const Rng& rng,
                              const EstimationPriors& priors = {});

}  // namespace diffsac
