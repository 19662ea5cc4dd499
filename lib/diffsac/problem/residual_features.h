#pragma once

#include <vector>

#include "diffsac/problem/point_features.h"

namespace diffsac {

inline constexpr int kColumnsPerHypothesis = 3;

/// How many hypotheses are described, and which.
struct KeptHypotheses {
  int count = 16;
  ResidualChoice choice = ResidualChoice::kBest;
};

/// Writes the columns of `residual` (PointFeatures) from column `first` on: the hypotheses are solved from the given
/// sets, γ indices each, and those that are kept are described. Sets the hypotheses, models and scores of the features.
void AddResidual(const NormalizedProblem& space, const std::vector<int>& sets, const KeptHypotheses& kept, int first,
                 FeatureSet* features);

}  // namespace diffsac
