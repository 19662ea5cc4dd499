#pragma once

#include <optional>
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
    /// As many as columns, or none: what stands behind a value in report.html, "[0.45, 0.57]"; empty for no interval.
    std::vector<std::string> intervals = {};
  };
  std::string heading;
  std::vector<std::string> columns;
  std::vector<Row> rows;
};

/// Stands in tables for what is not known.
inline constexpr const char* kUnknown = "–";

/// What is said of one method on one condition.
struct CellReport {
  std::vector<MetricValue> metrics;                        ///< CellMetrics.
  ConfidenceInterval accuracy;                             ///< mAA, or recall, with its 95 % bootstrap interval.
  ConfidenceInterval sets;                                 ///< The same of SetsOf; NaN where it is unknown.
  std::optional<ConfidenceInterval> reference_minus_this;  ///< DifferenceOf the reference row and this one.
};

/// By comparison (ExperimentOptions::compare), then by condition.
using Differences = std::vector<std::vector<std::optional<ConfidenceInterval>>>;

/// All that a run's tables, files and pictures say, computed once from its records: metrics, bootstraps, tables.
/// It refers to the results, which must outlive it.
struct Report {
  const ExperimentResults& results;
  std::vector<CellReport> cells;  ///< As `results.cells`.
  Differences differences;        ///< Of the accuracy.
  Differences set_differences;    ///< Of SetsOf.
  std::vector<Table> tables;      ///< MakeTables.

  /// What is said of one of `results.cells`.
  const CellReport& Of(const Cell& cell) const { return cells[static_cast<std::size_t>(&cell - results.cells.data())]; }
  /// A metric of a row on a condition ("mean" and kAllPairs are scenes too); NaN where it is unknown.
  double Metric(std::size_t condition, std::size_t method, const std::string& scene, const std::string& metric) const;
};

Report MakeReport(const ExperimentResults& results);
Report MakeReport(ExperimentResults&& results) = delete;

}  // namespace diffsac
