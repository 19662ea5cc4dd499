#pragma once

#include <string>
#include <vector>

#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// Which points of a training item are labelled +1.
///   kMinimalSet  "minimal_set": an optimal minimal set, the paper's
///   kStructure   "structure": all true inliers, of several structures those of one: a set is then what the reverse
///                process puts first among the points of the structure that it has settled on
enum class LabelTarget { kMinimalSet, kInstance };
template <>
inline constexpr auto kEnumNames<LabelTarget> = NamesOf<LabelTarget>({{LabelTarget::kMinimalSet, "minimal_set"},
                                                                      {LabelTarget::kInstance, "structure"}});

struct LabelOptions {
  LabelTarget target = LabelTarget::kMinimalSet;
  int top_m = 1;
  int search_budget = 2000;
  int draws = 300;
  double truncation_factor = 3.0;
  /// By which of the task's models sets are solved; empty: its own. The training configuration's `model`, no key here.
  std::string model;
  void Bind(OptionsBinder& b);
};

/// A minimal set and its distance to the ground truth.
struct RankedSet {
  std::vector<int> points;  ///< γ indices, ascending.
  double distance = 0.0;
};

/// The example as one of this structure alone (its place in GroundTruth::structures): the points of others are
/// outliers.
Example OfInstance(const Example& example, std::size_t instance);

/// The (up to) M sets of γ true inliers whose model is nearest to the ground-truth model, best first. Empty when there
/// are fewer than γ true inliers. What a set's distance is, and which sets are looked at, is the task's own:
/// OptimalHyperplaneSets for lines and planes, BestRandomSets (labels.cpp) for the rest. They depend on the example
/// alone, so an example has the same sets in every epoch. Of several structures
/// (GroundTruth::structures) up to M of each, one structure behind the other: a set drawn from all of them stands for
/// each alike. Throws Error when options.model is none of the example's task.
std::vector<RankedSet> OptimalMinimalSets(const Example& example, const LabelOptions& options, int count);

/// OptimalMinimalSets of lines and planes. Distance: RMS over the true inliers of the candidate model's residual at the
/// inlier's projection onto the ground-truth model, in the data's unit. Pairs are searched exhaustively, triplets
/// within options.search_budget. D: 2 or 3.
template <int D>
std::vector<RankedSet> OptimalHyperplaneSets(const Example& example, const LabelOptions& options, int count);

/// The points that may be labelled +1 together, by options.target: up to top_m optimal minimal sets, or the true
/// inliers, of each structure.
std::vector<std::vector<int>> LabelSets(const Example& example, const LabelOptions& options);

}  // namespace diffsac
