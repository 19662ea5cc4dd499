#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lab/eval/effects.h"
#include "lab/eval/strata.h"

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

struct Report;

/// Of fewer problems in a bin no interval is told: redrawing them says nothing of those that are not there.
inline constexpr std::size_t kLeastOfInterval = 5;

/// What is said of the problems in one bin of a division (ExperimentOptions::strata).
struct StratumReport {
  Stratum stratum;
  std::vector<ConfidenceInterval> accuracies;  ///< As `results.cells`, their mean and interval; NaN where unknown.
  Differences differences;                     ///< Of the accuracy.
  std::vector<FactorEffects> effects;          ///< By condition.

  /// The accuracy of one of the run's cells.
  const ConfidenceInterval& Of(const Report& report, const Cell& cell) const;
};

/// One division: every bin.
struct StrataReport {
  StrataOptions options;
  std::vector<StratumReport> strata;
  std::vector<std::size_t> unknown;  ///< By condition, the problems that are in no bin.

  /// Whether any problem is in a bin.
  bool known() const;
};

/// All that a run's tables, files and pictures say, computed once from its records: metrics, bootstraps, tables.
/// It refers to the results, which must outlive it.
struct Report {
  const ExperimentResults& results;
  std::vector<CellReport> cells;       ///< As `results.cells`.
  Differences differences;             ///< Of the accuracy.
  Differences set_differences;         ///< Of SetsOf.
  std::vector<FactorEffects> effects;  ///< By condition.
  std::vector<StrataReport> strata;    ///< As ExperimentOptions::strata.
  std::vector<Table> tables;           ///< MakeTables.

  /// What is said of one of `results.cells`.
  const CellReport& Of(const Cell& cell) const { return cells[static_cast<std::size_t>(&cell - results.cells.data())]; }
  /// A metric of a row on a condition ("mean" and kAllPairs are scenes too); NaN where it is unknown.
  double Metric(std::size_t condition, std::size_t method, const std::string& scene, const std::string& metric) const;
};

/// Whether the accuracy of any row is known.
bool HasTruth(const Report& report);

Report MakeReport(const ExperimentResults& results);
Report MakeReport(ExperimentResults&& results) = delete;

}  // namespace diffsac
