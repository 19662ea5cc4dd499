#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "lab/report/report.h"

namespace diffsac {

struct CurvePoint {
  double x = 0.0;
  double y = 0.0;
};

/// How a curve is drawn: an estimator, one that the reader should see first, the oracle's ceiling, another reference.
enum class CurveKind { kMethod, kStrong, kCeiling, kReference };

struct Curve {
  std::string label;
  CurveKind kind = CurveKind::kMethod;
  std::size_t colour = 0;  ///< SeriesColour.
  std::vector<CurvePoint> points;
};

/// mAA against the conditions' values, a curve a method; only curves of two points and more.
std::vector<Curve> ConditionCurves(const Report& report);

/// The curves of one condition.
struct CurvePanel {
  std::size_t condition = 0;
  std::vector<Curve> curves;
};
/// mAA against a cost, a curve a series of budgets, and the ceiling over the whole axis: the panels that have something
/// to show; `cost` is a metric.
std::vector<CurvePanel> CostPanels(const Report& report, const std::string& cost);

/// mAA against the places of a division's bins (0, 1, ...), a curve a row: of up to four conditions. Of more than
/// twelve rows, those that comparisons name come first, then the best of the first condition.
std::vector<CurvePanel> StrataPanels(const Report& report, const StrataReport& strata);

/// At most four of these, evenly spread.
std::vector<std::size_t> EvenlyChosen(const std::vector<std::size_t>& conditions);

/// One cluster of bars, one a row.
struct BarCluster {
  std::string label;
  std::vector<ConfidenceInterval> bars;
};
/// The rows of `figures.bars`.
std::vector<std::size_t> BarRows(const ExperimentOptions& experiment);
/// mAA of the rows: lines and planes a cluster a condition; poses two a condition, rotation and translation.
std::vector<BarCluster> BarClusters(const Report& report, const std::vector<std::size_t>& rows);

}  // namespace diffsac
