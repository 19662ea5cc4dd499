#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lab/eval/report.h"

namespace diffsac {

/// The tables of an experiment, from the report's metrics and differences: mAA (with hypotheses and milliseconds a
/// problem, medians over all problems) and the median error; for data without ground truth the median number of inliers
/// instead. With several scenes the first is the unweighted mean over them, followed by mAA over all pairs, and there
/// is a table by scene for each condition. Two views: the pose that a person is given, rotation and translation on
/// their own, exact AUC and failures. Of several structures misclassification, recall and minimal sets instead. Of a
/// person's own points the models. What results.json has beside them, comparisons, effects, strata, the paper's values
/// beside ours, is laid out by scripts/report.
std::vector<Table> MakeTables(const Report& report);

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

/// The lines or planes that were found in a person's own points (data of type point_sets), a row a model: normal,
/// offset, inliers and noise, in the unit of the points. No rows for other data, and where no estimates are kept.
Table ModelTable(const ExperimentResults& results);

/// The largest number of scenes that a condition has.
std::size_t MostScenes(const ExperimentResults& results);

/// What a note under them says of the metrics.
inline constexpr const char* kInstanceNote =
    " Misclassification: per cent of points with a wrong label, over all problems; recall: share of the true "
    "structures "
    "that are found.";

}  // namespace diffsac
