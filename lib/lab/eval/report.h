#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lab/eval/results.h"

namespace diffsac {

/// All choices of a level of each factor, the last factor's changing fastest.
std::vector<std::vector<std::string>> CombinationsOf(const Factors& factors);

/// What one level of a factor makes of a problem, on average over all combinations of the other factors' levels of
/// which both this level and the factor's first have a row.
struct LevelEffect {
  std::size_t combinations = 0;  ///< How many these are; 0: nothing is known.
  /// The accuracy minus the first level's, of the same problem and combination (docs/metrics.md). Of the first level
  /// itself: its mean accuracy. Nothing without truth.
  std::optional<ConfidenceInterval> accuracy;
  /// The milliseconds divided by the first level's, geometric mean. Of the first level itself: its geometric mean.
  std::optional<ConfidenceInterval> milliseconds;
};

/// By factor (ExperimentOptions::factors), then by level, with 95 % intervals: a problem's values in all combinations
/// are redrawn together, within its scene, and scenes weigh the same, as in DifferenceOf. Of one factor they are
/// DifferenceOf.
using FactorEffects = std::vector<std::vector<LevelEffect>>;
FactorEffects EffectsOf(const ExperimentResults& results, std::size_t condition);

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
