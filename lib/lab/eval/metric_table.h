#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lab/eval/report.h"

namespace diffsac {

/// One column of numbers: a metric of one condition and scene ("mean" and kAllPairs included).
struct MetricColumn {
  std::string heading;
  std::size_t condition = 0;
  std::string scene = "mean";
  std::string metric;
  int digits = 3;
  bool higher_is_better = true;
  std::optional<double> PaperValue::*paper = nullptr;  ///< The paper's value for it, null where it gives none.
  double scale = 1.0;                                  ///< What is shown is so many times the metric.
};

/// What a table of metrics shows: a row for each method.
struct MetricTable {
  std::string heading;
  std::vector<MetricColumn> columns;
  bool costs = false;      ///< Hypotheses and milliseconds beside the numbers.
  bool intervals = false;  ///< Each number is followed by its interval where it has one.
  bool best = true;        ///< Whether the best values are marked.
};

/// "0.512" (FixedNumber), kUnknown for NaN.
std::string FixedText(double value, int digits);

/// ", ratio 0.85": what stands behind a heading where there are several conditions, else nothing.
std::string ConditionText(const ExperimentOptions& experiment, std::size_t condition);

/// `one` for each condition, under the condition's label ("0.5", or "0.5: unit").
void AddConditions(const ExperimentResults& results, const MetricColumn& one, const std::string& unit,
                   MetricTable* table);

/// Whether the competing rows of a condition are of the same problems, or of some of them.
bool RowsShareProblems(const ExperimentResults& results, std::size_t condition);

/// The rows of methods that ran, then the paper's. The best value of a column is marked where its rows share their
/// problems; references (EstimatorRow::Competes) and the paper's values are left out of that.
Table FillTable(const Report& report, const MetricTable& shown);

}  // namespace diffsac
