#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lab/eval/interval_table.h"

namespace diffsac {

/// One level of one factor, of ExperimentOptions::factors.
struct FactorLevel {
  std::size_t factor = 0, level = 0;
};

/// All of them, in their order, and what tables and pictures call one: "score: pritts".
std::vector<FactorLevel> LevelsOf(const ExperimentOptions& experiment);
std::string LevelName(const ExperimentOptions& experiment, const FactorLevel& at);

/// What a table shows of an effect: LevelEffect::accuracy or milliseconds.
using EffectPart = std::optional<ConfidenceInterval> LevelEffect::*;

/// A row for each level under these columns, effects by column: the first level of each factor with its own mean, the
/// others with what they add to it, or by how much they multiply it.
Table EffectTable(const ExperimentOptions& experiment, const std::string& heading,
                  const std::vector<std::string>& columns, const std::vector<const FactorEffects*>& effects,
                  EffectPart part);

/// The experiment's effects by condition, on the accuracy where the truth is known and on the milliseconds; none
/// without factors.
std::vector<Table> EffectTables(const Report& report);

/// What a note under them says.
inline constexpr const char* kEffectNote =
    "Effects: the first level of a factor with its own mean; of the others the difference from it, or the ratio to it, "
    "of the same problems, averaged over all combinations of the other factors' levels that both have; in bold where "
    "the interval leaves 0, or 1, out.\n";

/// The levels that some combinations have no row of (a network that is not there), with how many are left: "Of fewer
/// combinations: order: network 2 of 4."; empty where all are there.
std::string MissingCombinations(const Report& report);

}  // namespace diffsac
