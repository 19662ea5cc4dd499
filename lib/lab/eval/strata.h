#pragma once

#include <string>
#include <vector>

#include "lab/eval/results.h"

namespace diffsac {

/// The problems in one bin of a quantity.
struct Stratum {
  std::string name;   ///< In results.csv, in the scene's place: "inlier_share below 0.1", "inlier_share 0.1-0.2", ...
  std::string label;  ///< In tables and pictures: "< 0.1", "0.1–0.2", "≥ 0.2"; a scene's name.
  std::vector<std::size_t> problems;  ///< How many, by condition.
  /// Of these problems alone, cells as in the whole results (some may be empty). All count as one scene, so that each
  /// weighs the same in means and is redrawn among all of its stratum: a scene that has one problem in a bin would
  /// otherwise weigh as much as one with forty, and never be redrawn.
  ExperimentResults results;
};

/// Every bin, empty ones as well; problems whose quantity is unknown are in none. Scenes in the order in which they
/// first appear.
std::vector<Stratum> StrataOf(const ExperimentResults& results, const StrataOptions& options);

/// The place of a value among ascending edges: how many of these are not above it.
std::size_t BinOf(double value, const std::vector<double>& edges);

/// How many different problems a condition has.
std::size_t ProblemsOf(const ExperimentResults& results, std::size_t condition);

}  // namespace diffsac
