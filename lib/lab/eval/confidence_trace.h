#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "diffsac/estimators/robust_estimator.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// One copy's confidences over the reverse steps of a diffusion method, for pictures.
struct ConfidenceTrace {
  std::vector<double> timesteps;               ///< From noise to data, one a step.
  std::vector<std::vector<float>> confidence;  ///< For each step N values, about -1 (not in the set) to +1 (in it).
};

/// Gives the trace of a method that has one, nothing for others. The program supplies it, so that evaluation needs to
/// know no diffusion method.
using TraceConfidence = std::function<std::optional<ConfidenceTrace>(const RobustEstimator& method,
                                                                     const Problem& problem, std::uint64_t seed)>;

}  // namespace diffsac
