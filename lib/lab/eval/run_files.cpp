#include "lab/eval/run_files.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "lab/eval/format.h"
#include "lab/eval/long_lines.h"
#include "lab/eval/markdown_report.h"
#include "lab/eval/record_fields.h"
#include "lab/eval/results_json.h"
#include "lab/files/files.h"

namespace diffsac {
namespace {

// An error that is unknown is empty, one of no end is "inf".
std::string ErrorText(double error) { return std::isinf(error) ? "inf" : NumberText(error); }

/// Appends ",VALUE" for each number that is visited.
struct AppendValues {
  std::string* text;
  void operator()(const char*, double value) const { *text += "," + ErrorText(value); }
  template <std::integral Count>
  void operator()(const char*, Count value) const {
    *text += "," + std::to_string(value);
  }
  void operator()(const char*, const std::vector<double>& values) const {
    *text += ",";
    for (std::size_t i = 0; i < values.size(); ++i) *text += (i == 0 ? "" : " ") + NumberText(values[i]);
  }
};

/// Appends ",NAME".
struct AppendNames {
  std::string* text;
  template <class Value>
  void operator()(const char* name, const Value&) const {
    *text += std::string(",") + name;
  }
};

// σ, the pose and the model; empty values for what is not known.
constexpr const char* kNoPose = ",,,,,,,";
constexpr const char* kNoEstimate = ",,,,,,,,";

std::string PoseValues(const RigidMotion& pose, Translation translation) {
  Eigen::Quaterniond q(pose.rotation);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  std::string text;
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) text += "," + NumberText(value);
  for (const double value : pose.translation) text += "," + (IsUndetermined(translation) ? "" : NumberText(value));
  return text;
}

// All digits: far from the origin, nine of a normal are not enough.
std::string ModelValues(const ModelParameters& model) {
  std::string text;
  for (const double value : model) text += (text.empty() ? "" : " ") + ShortestNumber(value);
  return text;
}

std::string EstimateText(const EstimateRecord& estimate) {
  const std::string noise = NumberText(estimate.noise_scale);
  return noise + (estimate.pose ? PoseValues(*estimate.pose, estimate.translation) : kNoPose) + "," +
         ModelValues(estimate.model);
}

std::vector<std::string> ConditionNames(const ExperimentOptions& experiment) {
  std::vector<std::string> names;
  for (const Condition& condition : experiment.conditions) names.push_back(condition.name);
  return names;
}

}  // namespace

std::string ResultsCsv(const Report& report) {
  const ExperimentResults& results = report.results;
  LongLines lines(results);
  for (const Cell& cell : results.cells)
    for (const MetricValue& value : report.Of(cell).metrics)
      lines.Add(value.scene, cell.condition, results.experiment.methods[cell.method].name, value.metric, value.value);
  AddEffectLines(report.effects, "mean", &lines);
  AddStrataLines(report, &lines);
  return lines.text();
}

std::string ProblemsCsv(const ExperimentResults& results) {
  const bool structures = JudgesStructures(results);
  std::string text = "id,scene,condition,method,status";
  const ProblemRecord any;
  VisitRecord(any, AppendNames{&text});
  text += ",noise_scale,qw,qx,qy,qz,tx,ty,tz,model";
  VisitChance(any, AppendNames{&text});
  VisitQuantities(any, AppendNames{&text});
  VisitLevels(any, AppendNames{&text});
  if (structures) VisitStructures(any, AppendNames{&text});
  text += "\n";
  for (const Cell& cell : results.cells) {
    const std::string names = "," + CsvText(results.experiment.conditions[cell.condition].name) + "," +
                              CsvText(results.experiment.methods[cell.method].name) + ",";
    for (std::size_t i = 0; i < cell.records.size(); ++i) {
      const ProblemRecord& record = cell.records[i];
      text += CsvText(record.id) + "," + CsvText(record.scene) + names + std::string(ToString(record.status));
      VisitRecord(record, AppendValues{&text});
      text += "," + (cell.estimates.empty() ? kNoEstimate : EstimateText(cell.estimates[i]));
      VisitChance(record, AppendValues{&text});
      VisitQuantities(record, AppendValues{&text});
      VisitLevels(record, AppendValues{&text});
      if (structures) VisitStructures(record, AppendValues{&text});
      text += "\n";
    }
  }
  return text;
}

void WriteResults(const Report& report, const std::string& folder) {
  WriteFileAtomically(folder + "/problems.csv", ProblemsCsv(report.results));
  WriteFileAtomically(folder + "/results.csv", ResultsCsv(report));
  RemoveFile(folder + "/reliability.csv");  // An earlier run's.
  if (!report.results.reliability.empty())
    WriteFileAtomically(folder + "/reliability.csv", ReliabilityCsv(DistinctCurves(report.results.reliability),
                                                                    ConditionNames(report.results.experiment)));
  WriteFileAtomically(folder + "/table.md", MarkdownReport(report));
}

void BeginResults(const std::string& folder) { RemoveFile(folder + "/results.json"); }

void EndResults(const Report& report, const std::string& folder) {
  const std::string config = folder + "/config.yaml";
  WriteFileAtomically(folder + "/results.json",
                      ResultsJson(report, std::filesystem::exists(config) ? ReadFile(config) : ""));
}

bool IsMade(const ExperimentOptions& experiment, const std::string& folder) {
  const std::string table = folder + "/table.md", config_path = folder + "/config.yaml",
                    json = folder + "/results.json";
  for (const std::string& path : {table, config_path, json})
    if (!std::filesystem::exists(path)) return false;
  const std::string config = ReadFile(config_path);
  const std::size_t header = config.find("\n\n");
  if (header == std::string::npos || config.substr(header + 2) != WriteExperiment(experiment)) return false;
  if (ReadFile(json).find("\"partial\": false") == std::string::npos) return false;
  std::vector<std::filesystem::path> sources = {std::filesystem::read_symlink("/proc/self/exe")};
  for (const EstimatorRow& row : experiment.methods)
    if (row.config.Has("checkpoint")) sources.emplace_back(row.config.Text("checkpoint"));
  return std::all_of(sources.begin(), sources.end(), [&](const std::filesystem::path& source) {
    return std::filesystem::exists(source) &&
           std::filesystem::last_write_time(source) < std::filesystem::last_write_time(table);
  });
}

}  // namespace diffsac
