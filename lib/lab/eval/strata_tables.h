#pragma once

#include <string>
#include <vector>

#include "lab/eval/report.h"

namespace diffsac {

/// "0.1–0.2 (66)": the bins of a division with the problems that a condition has in them.
std::vector<std::string> StrataColumns(const StrataReport& strata, std::size_t condition);

/// The rows that a division is shown for: those that it names, or all.
std::vector<std::size_t> StrataRows(const ExperimentOptions& experiment, const StrataOptions& options);

/// Tables of each division and condition, a column a bin: the accuracy (of scenes it stands by itself already, see
/// MakeTables), the experiment's comparisons, its effects. Divisions by what is unknown have none.
std::vector<Table> StrataTables(const Report& report);

/// How strata are made, and what of them is left out, a line; empty without strata.
std::string StrataNote(const Report& report);

}  // namespace diffsac
