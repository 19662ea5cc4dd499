#pragma once

#include <string>

#include "lab/eval/report.h"

namespace diffsac {

/// Markdown with aligned columns, ready to read on a terminal.
std::string MarkdownTable(const Table& table);

/// How the results were measured, in a line: problems, conditions, seed.
std::string ReportSetting(const ExperimentResults& results);

/// What the tables' columns mean.
std::string ReportNotes(const Report& report);

/// The whole table.md: title, how it was measured, the tables, notes.
std::string MarkdownReport(const Report& report);

}  // namespace diffsac
