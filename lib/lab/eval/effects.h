#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "lab/eval/results.h"

namespace diffsac {

/// All choices of a level of each factor, the last factor's changing fastest.
std::vector<std::vector<std::string>> CombinationsOf(const Factors& factors);

/// What one level of a factor makes of a problem, on average over all combinations of the other factors' levels of
/// which both this level and the factor's first have a row.
struct LevelEffect {
  std::size_t combinations = 0;  ///< How many these are; 0: nothing is known.
  /// The accuracy minus the first level's, of the same problem and combination (docs/metrics.md). Of the first level
  /// itself: its mean accuracy. Nothing without truth.
  std::optional<ConfidenceInterval> accuracy;
  /// The milliseconds divided by the first level's, geometric mean. Of the first level itself: its geometric mean.
  std::optional<ConfidenceInterval> milliseconds;
};

/// By factor (ExperimentOptions::factors), then by level, with 95 % intervals: a problem's values in all combinations
/// are redrawn together, within its scene, and scenes weigh the same, as in DifferenceOf. Of one factor they are
/// DifferenceOf.
using FactorEffects = std::vector<std::vector<LevelEffect>>;
FactorEffects EffectsOf(const ExperimentResults& results, std::size_t condition);

}  // namespace diffsac
