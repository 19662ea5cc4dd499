#pragma once

#include <memory>
#include <string>

#include "diffsac/guidance/engine/set_scorer.h"
#include "diffsac/problem/problem.h"
#include "diffsac/ransac/instances/instances.h"

namespace diffsac {

/// Chooses vanishing points one after the other: of a pool (problem/vanishing_point_pool.h) the one that a network,
/// which learned from people's labels, expects to add most to those taken.
class VanishingPointChooser : public InstanceChooser {
 public:
  explicit VanishingPointChooser(std::shared_ptr<const SetScorer> scorer) : scorer_(std::move(scorer)) {}
  ChosenInstances Choose(const PointMatrix& points, const Eigen::VectorXd& weights,
                         const std::vector<ModelParameters>& hypotheses, int most, double least) const override;

 private:
  std::shared_ptr<const SetScorer> scorer_;
};

/// Sets options->chosen_by, where that is asked for and absent, to the chooser of options->chooser, a file that
/// `method: structure_chooser` trained and that is read once. Throws Error naming the file.
void LoadChooser(InstanceSearchOptions* options);

/// Lengths of segments as MakeVanishingPointPool takes them, from their PointWeights.
Eigen::VectorXd PoolLengths(const Eigen::VectorXd& weights);

}  // namespace diffsac
