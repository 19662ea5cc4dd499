#include "lab/eval/paper_table.h"

#include <cmath>
#include <cstdio>
#include <optional>

namespace diffsac {
namespace {

// One of the paper's metrics: its value, and the error that ours is made of; null: the task's main one.
struct PaperMetric {
  const char* name;
  std::optional<double> PaperValue::*paper;
  double EstimateError::*error;
};

constexpr PaperMetric kMetrics[] = {{"mAA", &PaperValue::accuracy, nullptr},
                                    {"mAA of R", &PaperValue::rotation, &EstimateError::rotation_deg},
                                    {"mAA of t", &PaperValue::translation, &EstimateError::translation_deg}};

ConfidenceInterval OursBy(const Report& report, const Cell& cell, const PaperMetric& metric) {
  if (metric.error == nullptr) return report.Of(cell).accuracy;
  const ExperimentResults& results = report.results;
  return BootstrapMean(SceneAccuracies(cell, results.experiment.tolerance(),
                                       [&](const EstimateError& error) { return error.*metric.error; }),
                       BootstrapRng(results));
}

template <class... Values>
std::string Text(const char* format, Values... values) {
  char text[96];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

void AddRow(const Report& report, const std::string& label, const PaperRow& paper, std::size_t condition,
            const PaperMetric& metric, Table* table) {
  const ExperimentOptions& experiment = report.results.experiment;
  const auto value = paper.values.find(experiment.conditions[condition].name);
  const Cell* cell = report.results.Find(condition, experiment.RowOf(paper.ours));
  if (value == paper.values.end() || !(value->second.*metric.paper) || cell == nullptr) return;
  const ConfidenceInterval ours = OursBy(report, *cell, metric);
  if (std::isnan(ours.mean)) return;
  const double theirs = *(value->second.*metric.paper);
  Table::Row row;
  row.cells = {experiment.methods[cell->method].label + " / " + label,
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

Table PaperTable(const Report& report) {
  const ExperimentOptions& experiment = report.results.experiment;
  Table table;
  table.heading = "ours beside the paper's, which was measured on other data";
  table.columns = {"ours / the paper's row", experiment.condition_label, "metric", "paper", "ours", "difference", "n"};
  for (const auto& [label, paper] : experiment.paper)
    for (std::size_t c = 0; c < experiment.conditions.size() && !paper.ours.empty(); ++c)
      for (const PaperMetric& metric : kMetrics) AddRow(report, label, paper, c, metric, &table);
  return table;
}

}  // namespace diffsac
