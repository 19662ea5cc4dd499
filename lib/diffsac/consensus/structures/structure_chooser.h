#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/geometry/points.h"

namespace diffsac {

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

}  // namespace diffsac
