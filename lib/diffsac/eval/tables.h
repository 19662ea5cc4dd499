#pragma once

#include <string>
#include <vector>

#include "diffsac/eval/results.h"

namespace diffsac {

/// One table before it is given a form: a heading, column names, rows of texts.
struct Table {
  struct Row {
    std::vector<std::string> cells;  ///< As many as columns; the first is the method's label.
    std::vector<bool> best;          ///< As many as columns: to be set in bold.
    bool from_paper = false;
  };
  std::string heading;
  std::vector<std::string> columns;
  std::vector<Row> rows;
};

/// The tables of an experiment: mAA (with hypotheses and milliseconds a problem, medians over all problems) and the
/// median error; for data without ground truth the median number of inliers instead. With several scenes the first is
/// the unweighted mean over them, followed by mAA over all pairs, and there is a table by scene for each condition. Two
/// views: rotation and translation on their own, exact AUC and failures. Last the experiment's comparisons. The best
/// value of a column is marked; references (MethodRow::Competes) and the paper's values are left out of that.
std::vector<Table> MakeTables(const ExperimentResults& results);

/// Markdown with aligned columns, ready to read on a terminal.
std::string MarkdownTable(const Table& table);

/// A tabular in the style of booktabs; special characters are escaped.
std::string LatexTable(const Table& table);

/// The whole table.md: title, how it was measured, the tables, notes.
std::string MarkdownReport(const ExperimentResults& results);

/// The whole table.tex: one `table` environment a table.
std::string LatexReport(const ExperimentResults& results);

}  // namespace diffsac
