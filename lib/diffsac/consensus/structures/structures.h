#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/core/options.h"
#include "diffsac/geometry/points.h"

namespace diffsac {

/// How several models are looked for in one point set.
///   kOne         "one": they are not; one model
///   kSequential  "sequential": one search after the other, each on the points that are left, with a sampler of its own
///   kAtOnce      "at_once": all sets are drawn and solved first; then the best hypothesis is chosen on the points that
///                are left, one after the other
///   kEnergy      "energy": of the same hypotheses those that, with labels of all points, make one energy least
///                (energy_search.h)
///   kChosen      "chosen": of the same hypotheses a StructureChooser takes some, in its order
enum class StructureSearch { kOne, kSequential, kAtOnce, kChosen, kEnergy };
template <>
inline constexpr auto kEnumNames<StructureSearch> = NamesOf<StructureSearch>({{StructureSearch::kOne, "one"},
                                                                              {StructureSearch::kSequential,
                                                                               "sequential"},
                                                                              {StructureSearch::kAtOnce, "at_once"},
                                                                              {StructureSearch::kChosen, "chosen"},
                                                                              {StructureSearch::kEnergy, "energy"}});

/// Structures that were chosen, the surest first, and how sure the chooser was of each beside those before it: a
/// probability.
struct ChosenStructures {
  std::vector<ModelParameters> models;
  std::vector<double> values;
};

/// What chooses structures among hypotheses for `structures.search: chosen`, whatever drew the hypotheses.
class StructureChooser {
 public:
  virtual ~StructureChooser() = default;
  /// Of `hypotheses`, models of the points, those that are structures, refined, the surest first; at most `most`, and
  /// none of which the chooser is less sure than `least`, a probability. weights: of the points (PointWeights), empty
  /// where they say alike.
  virtual ChosenStructures Choose(const PointMatrix& points, const Eigen::VectorXd& weights,
                                  const std::vector<ModelParameters>& hypotheses, int most, double least) const = 0;
};

/// The group `structures` of a row.
struct StructureSearchOptions {
  StructureSearch search = StructureSearch::kOne;
  int most = 20;  ///< Structures that are looked for at most.
  /// A structure is taken while chance gives fewer than 10 to this power of its like (LogChanceModels): the score that
  /// stops the search.
  double log_false_alarms = 0.0;
  /// A point anywhere is within ε of a model with this probability at least. Outliers that are not uniform, correct
  /// matches of other depths say, fit by chance more often than uniform ones, from which it is otherwise reckoned.
  double least_chance = 0.0;
  /// Rounds in which each point goes to the model that it is nearest to, and each model is refitted to its points. Of
  /// kEnergy: in which models are drawn within structures, added, merged and removed.
  int rounds = 2;
  // Of kEnergy (energy_search.h), in units of the cost of a point as far from its model as can be.
  double core = 0.2;             ///< c: the cost of a residual begins to rise at this share of ε.
  double reach = 6.0;            ///< R: so many ε from its model a point can be.
  double outlier_cost = 0.4;     ///< Of a point without a model.
  double support_weight = 0.35;  ///< Of what a match's neighbours say for it; 0: they are not asked.
  double structure_cost = 5.0;   ///< Of each model: so many points have to speak for it.
  double spatial_weight = 0.15;  ///< Of two neighbours with different models.
  int neighbors = 6;             ///< Nearest points, in all coordinates, that are a point's neighbours.
  std::string chooser;           ///< Of kChosen: the file of its network.
  double least_value = 0.0;      ///< Of kChosen: a structure is taken of which it is so sure.
  std::shared_ptr<const StructureChooser> chosen_by = {};  ///< Of kChosen, by whoever read that file.
  void Bind(OptionsBinder& b);
  bool Several() const { return search != StructureSearch::kOne; }
};

/// Several models with disjoint inliers, that of most points (of most weight, where they have weights) first; of
/// kChosen the surest first.
struct StructuresResult {
  /// kNoModel, and no models: nothing that chance would not give. The points' own, where they are unfit.
  Status status = Status::kNoModel;
  std::vector<ModelParameters> models;
  std::vector<double> values;  ///< Of kChosen: how sure the chooser was of each; empty for others.
  /// N values: 0 for none, k for models[k − 1], from which it is at most ε away, of kEnergy reach · ε.
  std::vector<std::int32_t> assignment;
  int hypotheses = 0;  ///< models solved or fitted, all stages
  int unique_minimal_sets = 0;
  std::int64_t iterations = 0;               ///< minimal sets drawn
  std::vector<std::vector<int>> first_sets;  ///< up to kReportedSets, in the points' rows
};

/// The minimal sets of points `rows` (ascending), as places among these; search: which one, 0 for the first.
using SamplerOfRows = std::function<std::unique_ptr<MinimalSampler>(const std::vector<int>& rows, int search)>;

/// Finds as many structures as the points have. Each choice of one model is a SampleConsensus of its own on the points
/// that are left: score, local optimisation, refit and what is known of the points (priors) act as they do there. It
/// ends with the first model that chance would give, or when too few points are left. Then points are assigned to the
/// nearest model and models refitted to their points; those that chance would then give are left out.
///
/// options.max_iterations: sets that are drawn, of `sequential` for each search. priors.models join the hypotheses of
/// the first search, or of all points.
template <MinimalModel Model>
StructuresResult FindStructures(const PointMatrix& points, double inlier_threshold, const SamplerOfRows& sampler_of,
                                const ConsensusOptions& options, const StructureSearchOptions& structures,
                                const Rng& rng, const EstimationPriors& priors = {});

}  // namespace diffsac
