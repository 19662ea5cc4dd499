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

/// A row of numbers before the best are known.
struct NumberRow {
  std::vector<double> values;
  bool competes = true;
};

/// Marks the best value of a column of numbers (the table's column after the method's), of the rows that compete; those
/// that print the same are equally good.
void MarkBest(const std::vector<NumberRow>& numbers, std::size_t column, int digits, bool higher_is_better,
              Table* table);

/// "0.512" (FixedNumber), kUnknown for NaN; and "[0.450, 0.570]", empty where the interval is unknown.
std::string FixedText(double value, int digits);
std::string RangeText(const ConfidenceInterval& interval, int digits);

/// ", ratio 0.85": what stands behind a heading where there are several conditions, else nothing.
std::string ConditionText(const ExperimentOptions& experiment, std::size_t condition);

/// "First − Second"
std::string ComparisonLabel(const ExperimentOptions& experiment, const Comparison& pair);

/// `one` for each condition, under the condition's label ("0.5", or "0.5: unit").
void AddConditions(const ExperimentResults& results, const MetricColumn& one, const std::string& unit,
                   MetricTable* table);

/// Whether the competing rows of a condition are of the same problems, or of some of them.
bool RowsShareProblems(const ExperimentResults& results, std::size_t condition);

/// The rows of methods that ran, then the paper's. The best value of a column is marked where its rows share their
/// problems; references (EstimatorRow::Competes) and the paper's values are left out of that.
Table FillTable(const Report& report, const MetricTable& shown);

}  // namespace diffsac
