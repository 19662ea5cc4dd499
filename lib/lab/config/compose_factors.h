#pragma once

#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/config_tree.h"

namespace diffsac {

/// Factors by name with the names of their levels.
using Factors = std::vector<std::pair<std::string, std::vector<std::string>>>;

/// All choices of a level of each factor, the last factor's changing fastest.
std::vector<std::vector<std::string>> CombinationsOf(const Factors& factors);

/// The row of a combination: its levels joined by "_".
std::string FactorRowName(const std::vector<std::string>& levels);

/// Makes rows of an experiment's `factors`, {score: {msac: {...}, counted: {...}}, draws: {"100": {...}, ...}}: a row
/// for each combination of levels, the last factor's changing fastest. Its name joins the levels' by "_"
/// (FactorRowName), its label by ", ". A level is a part of a row as a setting is, with `use`; later factors override
/// earlier ones, and the experiment's `factors_base`, what all of these rows share, is under all of them. What
/// `methods` has under a combination's name overrides its keys; other methods stand behind. In the document the levels'
/// names are left, {score: [msac, counted], ...}; factors that are these names already are rows that are there. Throws
/// Error (file, line).
void ComposeFactors(ConfigTree* experiment);

}  // namespace diffsac
