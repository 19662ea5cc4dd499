#include "lab/eval/report.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/eval/tables.h"

namespace diffsac {
namespace {

CellReport MakeCellReport(const ExperimentResults& results, const Cell& cell) {
  const Tolerance c = results.experiment.tolerance();
  CellReport report;
  report.metrics = CellMetrics(cell, c);
  report.accuracy = BootstrapMean(SceneAccuracies(cell, c), BootstrapRng(results));
  report.sets = BootstrapMean(SceneValuesOf(cell, SetsOf), BootstrapRng(results));
  const int reference = ReferenceRow(results.experiment);
  if (reference >= 0)
    report.reference_minus_this =
        DifferenceOf(results, cell.condition, static_cast<std::size_t>(reference), cell.method);
  return report;
}

Differences DifferencesOf(const ExperimentResults& results, const ValueOf& value_of) {
  const ExperimentOptions& experiment = results.experiment;
  Differences differences;
  for (const Comparison& pair : experiment.compare) {
    const std::size_t a = experiment.RowOf(pair.a), b = experiment.RowOf(pair.b);
    auto& by_condition = differences.emplace_back();
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c)
      by_condition.push_back(DifferenceOf(results, c, a, b, value_of));
  }
  return differences;
}

Differences AccuracyDifferences(const ExperimentResults& results) {
  const Tolerance tolerance = results.experiment.tolerance();
  return DifferencesOf(results, [&](const ProblemRecord& record) { return AccuracyOf(record.error, tolerance); });
}

std::vector<FactorEffects> EffectsByCondition(const ExperimentResults& results) {
  std::vector<FactorEffects> effects;
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c) effects.push_back(EffectsOf(results, c));
  return effects;
}

void ForgetRange(ConfidenceInterval* interval) { interval->low = interval->high = std::nan(""); }

void ForgetRange(std::optional<ConfidenceInterval>* interval) {
  if (*interval) ForgetRange(&**interval);
}

void ForgetRanges(std::size_t condition, StratumReport* report) {
  const std::vector<Cell>& cells = report->stratum.results.cells;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i].condition == condition) ForgetRange(&report->accuracies[i]);
  for (auto& by_condition : report->differences) ForgetRange(&by_condition[condition]);
  for (auto& levels : report->effects[condition])
    for (LevelEffect& effect : levels)
      for (auto* interval : {&effect.accuracy, &effect.milliseconds}) ForgetRange(interval);
}

StratumReport MakeStratumReport(Stratum stratum) {
  StratumReport report;
  report.stratum = std::move(stratum);
  const ExperimentResults& results = report.stratum.results;
  const Tolerance tolerance = results.experiment.tolerance();
  for (const Cell& cell : results.cells)
    report.accuracies.push_back(BootstrapMean(SceneAccuracies(cell, tolerance), BootstrapRng(results)));
  report.differences = AccuracyDifferences(results);
  report.effects = EffectsByCondition(results);
  for (std::size_t c = 0; c < report.effects.size(); ++c)
    if (report.stratum.problems[c] < kLeastOfInterval) ForgetRanges(c, &report);
  return report;
}

StrataReport MakeStrataReport(const ExperimentResults& results, const StrataOptions& options) {
  StrataReport report{options, {}, {}};
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c)
    report.unknown.push_back(ProblemsOf(results, c));
  for (Stratum& stratum : StrataOf(results, options)) {
    for (std::size_t c = 0; c < report.unknown.size(); ++c) report.unknown[c] -= stratum.problems[c];
    report.strata.push_back(MakeStratumReport(std::move(stratum)));
  }
  return report;
}

}  // namespace

double Report::Metric(std::size_t condition, std::size_t method, const std::string& scene,
                      const std::string& metric) const {
  const Cell* cell = results.Find(condition, method);
  return cell == nullptr ? std::nan("") : FindMetric(Of(*cell).metrics, scene, metric);
}

bool StrataReport::known() const {
  return std::any_of(strata.begin(), strata.end(), [](const StratumReport& one) {
    const auto& problems = one.stratum.problems;
    return std::any_of(problems.begin(), problems.end(), [](std::size_t count) { return count > 0; });
  });
}

bool HasTruth(const Report& report) {
  return std::any_of(report.cells.begin(), report.cells.end(),
                     [](const CellReport& cell) { return !std::isnan(cell.accuracy.mean); });
}

Report MakeReport(const ExperimentResults& results) {
  Report report{results, {}, {}, {}, {}, {}, {}};
  for (const Cell& cell : results.cells) report.cells.push_back(MakeCellReport(results, cell));
  report.differences = AccuracyDifferences(results);
  report.set_differences = DifferencesOf(results, SetsOf);
  report.effects = EffectsByCondition(results);
  for (const StrataOptions& options : results.experiment.strata)
    report.strata.push_back(MakeStrataReport(results, options));
  report.tables = MakeTables(report);
  return report;
}

}  // namespace diffsac
