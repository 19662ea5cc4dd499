#include "diffsac/eval/outputs.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <map>

#include "diffsac/core/files.h"
#include "diffsac/core/run_directory.h"
#include "diffsac/eval/tables.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

std::string NumberText(double value) {
  if (!std::isfinite(value)) return "";
  char text[40];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

// Quoted only when it must be.
std::string CsvText(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

Json NumberJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json IntervalJson(const ConfidenceInterval& interval) {
  return {{"mean", NumberJson(interval.mean)}, {"low", NumberJson(interval.low)}, {"high", NumberJson(interval.high)}};
}

Rng BootstrapRng(const ExperimentResults& results) { return Rng(results.experiment.seed).Fork("bootstrap"); }

// The records of `cell` whose problems are in `other` too: rows may have different numbers of problems.
Cell Common(const Cell& cell, const Cell& other) {
  std::map<std::uint64_t, bool> indices;
  for (const ProblemRecord& record : other.records) indices[record.index] = true;
  Cell common{cell.condition, cell.method, {}};
  for (const ProblemRecord& record : cell.records)
    if (indices.count(record.index) > 0) common.records.push_back(record);
  return common;
}

// How much better the reference is on the same problems; null for itself and without ground truth.
Json DifferenceJson(const ExperimentResults& results, const Cell& cell) {
  const int reference = ReferenceRow(results.experiment);
  if (reference < 0 || static_cast<std::size_t>(reference) == cell.method) return nullptr;
  const Cell* other = results.Find(cell.condition, reference);
  if (other == nullptr) return nullptr;
  const Tolerance c = results.experiment.tolerance();
  const SceneValues a = SceneAccuracies(Common(*other, cell), c), b = SceneAccuracies(Common(cell, *other), c);
  if (a.empty() || b.empty()) return nullptr;
  Json json = {{"reference", results.experiment.methods[reference].name}};
  json.update(IntervalJson(BootstrapDifference(a, b, BootstrapRng(results))));
  return json;
}

Json CellJson(const ExperimentResults& results, const Cell& cell) {
  const Tolerance c = results.experiment.tolerance();
  Json scenes = Json::object();
  for (const MetricValue& value : CellMetrics(cell, c)) scenes[value.scene][value.metric] = NumberJson(value.value);
  const MethodRow& row = results.experiment.methods[cell.method];
  return {
      {"condition", results.experiment.conditions[cell.condition].name},
      {"method", row.name},
      {"type", row.type},
      {"label", row.label},
      {"metrics", scenes},
      {MetricName("mAA", c) + "_ci95", IntervalJson(BootstrapMean(SceneAccuracies(cell, c), BootstrapRng(results)))},
      {"reference_minus_this", DifferenceJson(results, cell)}};
}

Json PaperJson(const ExperimentResults& results) {
  Json rows = Json::object();
  for (const PaperRow& row : results.experiment.paper)
    for (const auto& [condition, value] : row.values)
      rows[row.label][condition] = {{"mAA", NumberJson(value.accuracy)}, {"median_deg", NumberJson(value.median_deg)}};
  return rows;
}

}  // namespace

std::string ResultsCsv(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  std::string text = "experiment,dataset,scene,condition,method,metric,value\n";
  for (const Cell& cell : results.cells) {
    for (const MetricValue& value : CellMetrics(cell, experiment.tolerance())) {
      text += CsvText(experiment.name) + "," + CsvText(results.dataset) + "," + CsvText(value.scene) + "," +
              CsvText(experiment.conditions[cell.condition].name) + "," +
              CsvText(experiment.methods[cell.method].name) + "," + value.metric + "," + NumberText(value.value) + "\n";
    }
  }
  return text;
}

std::string ProblemsCsv(const ExperimentResults& results) {
  std::string text =
      "id,scene,condition,method,status,angle_deg,offset,rotation_deg,translation_deg,error_px,inliers,hypotheses,"
      "ms_features,ms_denoise,ms_consensus,ms_total\n";
  for (const Cell& cell : results.cells) {
    const std::string names = "," + CsvText(results.experiment.conditions[cell.condition].name) + "," +
                              CsvText(results.experiment.methods[cell.method].name) + ",";
    for (const ProblemRecord& record : cell.records) {
      text += CsvText(record.id) + "," + CsvText(record.scene) + names + std::string(ToString(record.status)) + "," +
              NumberText(record.error.angle_deg) + "," + NumberText(record.error.offset) + "," +
              NumberText(record.error.rotation_deg) + "," + NumberText(record.error.translation_deg) + "," +
              NumberText(record.error.error_px) + "," +
              std::to_string(record.inliers) + "," + std::to_string(record.report.hypotheses) + "," +
              NumberText(record.report.ms_features) + "," + NumberText(record.report.ms_denoise) + "," +
              NumberText(record.report.ms_consensus) + "," + NumberText(record.report.ms_total) + "\n";
    }
  }
  return text;
}

std::string ResultsJson(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  const Tolerance c = experiment.tolerance();
  Json cells = Json::array();
  for (const Cell& cell : results.cells) cells.push_back(CellJson(results, cell));
  const Json json = {{"experiment", experiment.name}, {"title", experiment.title},
                     {"task", experiment.task},       {"dataset", results.dataset},
                     {"seed", experiment.seed},       {c.pixels ? "threshold_px" : "threshold_deg", c.value},
                     {"partial", results.partial},    {"git_revision", GitRevision()},
                     {"machine", MachineText()},      {"results", cells},
                     {"paper", PaperJson(results)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void WriteResults(const ExperimentResults& results, const std::string& folder) {
  WriteFileAtomically(folder + "/problems.csv", ProblemsCsv(results));
  WriteFileAtomically(folder + "/results.csv", ResultsCsv(results));
  WriteFileAtomically(folder + "/results.json", ResultsJson(results));
  WriteFileAtomically(folder + "/table.md", MarkdownReport(results));
  WriteFileAtomically(folder + "/table.tex", LatexReport(results));
}

}  // namespace diffsac
