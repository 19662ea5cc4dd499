#include "lab/report/plot_series.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lab/report/strata_tables.h"

namespace diffsac {
namespace {

CurvePoint AccuracyAt(const Report& report, std::size_t condition, std::size_t method, double x) {
  return {x, report.Metric(condition, method, "mean", AccuracyMetric(report.results))};
}

CurveKind KindOf(const EstimatorRow& row) {
  if (row.type == "oracle") return CurveKind::kCeiling;
  if (!row.Competes()) return CurveKind::kReference;
  return row.type == "diffsac" ? CurveKind::kStrong : CurveKind::kMethod;
}

/// The points of one series of budgets, by their cost.
std::vector<CurvePoint> SeriesPoints(const Report& report, std::size_t condition, const std::string& cost,
                                     const BudgetSeries& series) {
  const auto& methods = report.results.experiment.methods;
  std::vector<CurvePoint> points;
  for (const std::string& name : series.methods) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      if (methods[m].name != name) continue;
      const CurvePoint point = AccuracyAt(report, condition, m, report.Metric(condition, m, "mean", cost));
      // The axis is logarithmic: what cost nothing has no place on it.
      if (point.x > 0.0 && !std::isnan(point.y)) points.push_back(point);
    }
  }
  std::sort(points.begin(), points.end(), [](const CurvePoint& a, const CurvePoint& b) { return a.x < b.x; });
  return points;
}

std::vector<Curve> CostCurves(const Report& report, std::size_t condition, const std::string& cost) {
  const ExperimentOptions& experiment = report.results.experiment;
  std::vector<Curve> curves;
  double low = 1e300, high = 0.0;
  for (const BudgetSeries& series : experiment.figures.budget) {
    Curve curve{series.label, curves.empty() ? CurveKind::kStrong : CurveKind::kMethod, curves.size(),
                SeriesPoints(report, condition, cost, series)};
    if (curve.points.empty()) continue;
    low = std::min(low, curve.points.front().x);
    high = std::max(high, curve.points.back().x);
    curves.push_back(std::move(curve));
  }
  for (std::size_t m = 0; m < experiment.methods.size() && !curves.empty(); ++m) {
    const double ceiling = AccuracyAt(report, condition, m, 0.0).y;
    if (experiment.methods[m].type == "oracle" && !std::isnan(ceiling))
      curves.push_back(
          {experiment.methods[m].label, CurveKind::kCeiling, curves.size(), {{low, ceiling}, {high, ceiling}}});
  }
  return curves;
}

/// Rows that comparisons name, in that order, then the others from the best of the first condition on.
std::vector<std::size_t> ByInterest(const Report& report, std::vector<std::size_t> rows) {
  const ExperimentOptions& experiment = report.results.experiment;
  std::vector<std::size_t> named;
  for (const Comparison& one : experiment.compare)
    named.insert(named.end(), {experiment.RowOf(one.a), experiment.RowOf(one.b)});
  const auto interest = [&](std::size_t row) {
    const auto place = std::find(named.begin(), named.end(), row) - named.begin();
    const double y = AccuracyAt(report, 0, row, 0.0).y;
    return std::pair(place, std::isnan(y) ? 1.0 : -y);
  };
  std::stable_sort(rows.begin(), rows.end(), [&](auto a, auto b) { return interest(a) < interest(b); });
  return rows;
}

/// The rows that a picture of a division has room for, in their order: the same in all its panels, which share a key.
std::vector<std::size_t> ShownRows(const Report& report, const StrataReport& strata) {
  constexpr std::size_t kMostCurves = 12;
  const std::vector<std::size_t> all = StrataRows(report.results.experiment, strata.options);
  if (all.size() <= kMostCurves) return all;
  std::vector<std::size_t> rows = ByInterest(report, all);
  rows.resize(kMostCurves);
  std::sort(rows.begin(), rows.end());
  return rows;
}

std::vector<Curve> StrataCurves(const Report& report, const StrataReport& strata, const std::vector<std::size_t>& rows,
                                std::size_t condition) {
  const ExperimentResults& results = report.results;
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Cell* cell = results.Find(condition, rows[i]);
    if (cell == nullptr) continue;
    const EstimatorRow& row = results.experiment.methods[rows[i]];
    Curve curve{row.label, KindOf(row), i, {}};
    for (std::size_t bin = 0; bin < strata.strata.size(); ++bin) {
      const double accuracy = strata.strata[bin].Of(report, *cell).mean;
      if (!std::isnan(accuracy)) curve.points.push_back({static_cast<double>(bin), accuracy});
    }
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

ConfidenceInterval Height(const Report& report, std::size_t condition, std::size_t method, const ErrorOf& error_of) {
  const Cell* cell = report.results.Find(condition, method);
  if (cell == nullptr) return {std::nan(""), std::nan(""), std::nan("")};
  if (!error_of) return report.Of(*cell).accuracy;
  const Tolerance tolerance = report.results.experiment.tolerance();
  return BootstrapMean(SceneAccuracies(*cell, tolerance, error_of), BootstrapRng(report.results));
}

}  // namespace

std::vector<Curve> ConditionCurves(const Report& report) {
  std::vector<Curve> curves;
  const ExperimentOptions& experiment = report.results.experiment;
  for (std::size_t m = 0; m < experiment.methods.size(); ++m) {
    const EstimatorRow& row = experiment.methods[m];
    Curve curve{row.label, KindOf(row), curves.size(), {}};
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c) {
      const CurvePoint point = AccuracyAt(report, c, m, experiment.conditions[c].value.value_or(std::nan("")));
      if (!std::isnan(point.x) && !std::isnan(point.y)) curve.points.push_back(point);
    }
    if (curve.points.size() >= 2) curves.push_back(std::move(curve));
  }
  return curves;
}

std::vector<CurvePanel> CostPanels(const Report& report, const std::string& cost) {
  std::vector<CurvePanel> panels;
  for (std::size_t c = 0; c < report.results.experiment.conditions.size(); ++c) {
    CurvePanel panel{c, CostCurves(report, c, cost)};
    if (!panel.curves.empty()) panels.push_back(std::move(panel));
  }
  return panels;
}

std::vector<std::size_t> EvenlyChosen(const std::vector<std::size_t>& conditions) {
  constexpr std::size_t kMost = 4;
  if (conditions.size() <= kMost) return conditions;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < kMost; ++i) chosen.push_back(conditions[i * (conditions.size() - 1) / (kMost - 1)]);
  return chosen;
}

std::vector<CurvePanel> StrataPanels(const Report& report, const StrataReport& strata) {
  std::vector<std::size_t> conditions(report.results.experiment.conditions.size());
  std::iota(conditions.begin(), conditions.end(), std::size_t{0});
  const std::vector<std::size_t> rows = ShownRows(report, strata);
  std::vector<CurvePanel> panels;
  for (const std::size_t c : EvenlyChosen(conditions)) {
    CurvePanel panel{c, StrataCurves(report, strata, rows, c)};
    if (!panel.curves.empty()) panels.push_back(std::move(panel));
  }
  return panels;
}

std::vector<std::size_t> BarRows(const ExperimentOptions& experiment) {
  std::vector<std::size_t> rows;
  for (const std::string& name : experiment.figures.bars) rows.push_back(experiment.RowOf(name));
  return rows;
}

std::vector<BarCluster> BarClusters(const Report& report, const std::vector<std::size_t>& rows) {
  const ExperimentResults& results = report.results;
  std::vector<BarCluster> clusters;
  const bool poses = JudgesPoses(results) && !JudgesStructures(results);
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c) {
    const std::string label = results.experiment.conditions[c].label;
    const auto add = [&](const std::string& name, const ErrorOf& error_of) {
      BarCluster cluster{name, {}};
      for (const std::size_t row : rows) cluster.bars.push_back(Height(report, c, row, error_of));
      const bool known = std::any_of(cluster.bars.begin(), cluster.bars.end(),
                                     [](const ConfidenceInterval& bar) { return !std::isnan(bar.mean); });
      if (known) clusters.push_back(std::move(cluster));
    };
    if (poses) {
      add(label + ", R", [](const EstimateError& error) { return error.rotation_deg; });
      add(label + ", t", [](const EstimateError& error) { return error.translation_deg; });
    } else {
      add(label, {});
    }
  }
  return clusters;
}

}  // namespace diffsac
