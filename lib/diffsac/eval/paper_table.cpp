#include "diffsac/eval/paper_table.h"

#include <cmath>
#include <cstdio>

namespace diffsac {
namespace {

// One of the paper's metrics: its value, and the error that ours is made of; null: the task's main one.
struct PaperMetric {
  const char* name;
  double PaperValue::*paper;
  double EstimateError::*error;
};

constexpr PaperMetric kMetrics[] = {{"mAA", &PaperValue::accuracy, nullptr},
                                    {"mAA of R", &PaperValue::rotation, &EstimateError::rotation_deg},
                                    {"mAA of t", &PaperValue::translation, &EstimateError::translation_deg}};

SceneValues AccuraciesOf(const Cell& cell, const Tolerance& tolerance, const PaperMetric& metric) {
  if (metric.error == nullptr) return SceneAccuracies(cell, tolerance);
  return SceneAccuracies(cell, tolerance, [&](const EstimateError& error) { return error.*metric.error; });
}

template <class... Values>
std::string Text(const char* format, Values... values) {
  char text[96];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

void AddRow(const ExperimentResults& results, const PaperRow& paper, std::size_t condition, const PaperMetric& metric,
            Table* table) {
  const ExperimentOptions& experiment = results.experiment;
  const auto value = paper.values.find(experiment.conditions[condition].name);
  const Cell* cell = results.Find(condition, experiment.RowOf(paper.ours));
  if (value == paper.values.end() || std::isnan(value->second.*metric.paper) || cell == nullptr) return;
  const SceneValues values = AccuraciesOf(*cell, experiment.tolerance(), metric);
  if (values.empty()) return;
  const ConfidenceInterval ours = BootstrapMean(values, BootstrapRng(results));
  const double theirs = value->second.*metric.paper;
  Table::Row row;
  row.cells = {experiment.methods[cell->method].label + " / " + paper.label,
               experiment.conditions[condition].label,
               metric.name,
               Text("%.3g", theirs),
               Text("%.3f [%.3f, %.3f]", ours.mean, ours.low, ours.high),
               Text("%+.3f", ours.mean - theirs),
               std::to_string(cell->records.size())};
  row.best.resize(row.cells.size());
  table->rows.push_back(std::move(row));
}

}  // namespace

Table PaperTable(const ExperimentResults& results) {
  Table table;
  table.heading = "ours beside the paper's, which was measured on other data";
  table.columns = {
      "ours / the paper's row", results.experiment.condition_label, "metric", "paper", "ours", "difference", "n"};
  for (const PaperRow& paper : results.experiment.paper)
    for (std::size_t c = 0; c < results.experiment.conditions.size() && !paper.ours.empty(); ++c)
      for (const PaperMetric& metric : kMetrics) AddRow(results, paper, c, metric, &table);
  return table;
}

}  // namespace diffsac
