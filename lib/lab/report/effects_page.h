#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "lab/report/report.h"

namespace diffsac {

/// A run whose experiment has factors, by its folder.
struct EffectRun {
  std::string folder;
  Report report;
};

/// "essential" and "line" for scoreboard_essential and scoreboard_line: the experiments' names without what they all
/// begin with, up to an underscore; of one run the whole name.
std::vector<std::string> ShortNames(const std::vector<std::string>& names);

/// All runs' effects side by side, a column a run and condition, a row for each level that any of them has: of the
/// accuracy, then of the milliseconds.
std::vector<Table> EffectOverview(const std::vector<EffectRun>& runs);

/// The best rows of a condition by accuracy, with its interval, hypotheses and milliseconds.
Table BestRows(const Report& report, std::size_t condition);

/// `diffsac_eval --effects RUN...`: what the factors of several runs decide, on one page: the overview, then for each
/// run its effects, best rows and strata, with the pictures that its folder has. Folders without a whole run are named.
/// Prints it and, where `page` is given, writes it there with copies of the pictures and `command`, which made it.
/// Throws Error for a run without factors, and where there is none at all.
void WriteEffectsPage(const std::vector<std::string>& folders, const std::string& page, const std::string& command,
                      std::ostream& out);

}  // namespace diffsac
