#include "diffsac/report/report.h"

#include <cmath>

#include "diffsac/report/tables.h"

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

}  // namespace

double Report::Metric(std::size_t condition, std::size_t method, const std::string& scene,
                      const std::string& metric) const {
  const Cell* cell = results.Find(condition, method);
  return cell == nullptr ? std::nan("") : FindMetric(Of(*cell).metrics, scene, metric);
}

Report MakeReport(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  Report report{results, {}, {}, {}, {}};
  for (const Cell& cell : results.cells) report.cells.push_back(MakeCellReport(results, cell));
  for (const Comparison& pair : experiment.compare) {
    auto& of_accuracy = report.differences.emplace_back();
    auto& of_sets = report.set_differences.emplace_back();
    const std::size_t a = experiment.RowOf(pair.a), b = experiment.RowOf(pair.b);
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c) {
      of_accuracy.push_back(DifferenceOf(results, c, a, b));
      of_sets.push_back(DifferenceOf(results, c, a, b, SetsOf));
    }
  }
  report.tables = MakeTables(report);
  return report;
}

}  // namespace diffsac
