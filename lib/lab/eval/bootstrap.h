#pragma once

#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {

/// Values of the problems of each scene: the statistic is the unweighted mean of the scenes' means.
using SceneValues = std::vector<std::vector<double>>;

struct ConfidenceInterval {
  double mean = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// Percentile bootstrap (Efron, "Bootstrap methods: another look at the jackknife", Annals of Statistics 1979) of the
/// mean; problems are redrawn within their scene. The same rng gives the same interval. NaN when there are no values.
ConfidenceInterval BootstrapMean(const SceneValues& values, Rng rng, int rounds = 1000, double level = 0.95);

/// The same for "A minus B" on the same problems: a problem's two values are always redrawn together. The shapes must
/// be equal (throws std::invalid_argument). A is better than B beyond chance when `low` is above 0.
ConfidenceInterval BootstrapDifference(const SceneValues& a, const SceneValues& b, Rng rng, int rounds = 1000,
                                       double level = 0.95);

}  // namespace diffsac
