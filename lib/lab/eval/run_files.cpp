#include "lab/eval/run_files.h"

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "diffsac/core/files.h"
#include "lab/eval/format.h"
#include "lab/eval/long_lines.h"
#include "lab/eval/markdown_report.h"
#include "lab/eval/problem_quantities.h"
#include "lab/eval/record_fields.h"
#include "lab/eval/strata_tables.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

Json NumberJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json KnownJson(const std::optional<double>& value) { return value ? NumberJson(*value) : Json(nullptr); }

Json IntervalJson(const ConfidenceInterval& interval) {
  return {{"mean", NumberJson(interval.mean)}, {"low", NumberJson(interval.low)}, {"high", NumberJson(interval.high)}};
}

// How much better the reference is on the same problems; null for itself and without ground truth.
Json DifferenceJson(const ExperimentOptions& experiment, const CellReport& cell) {
  if (!cell.reference_minus_this) return nullptr;
  Json json = {{"reference", experiment.methods[ReferenceRow(experiment)].name}};
  json.update(IntervalJson(*cell.reference_minus_this));
  return json;
}

// The experiment's comparisons, each condition's.
void AddComparisons(const Report& report, const std::string& metric, const Differences& differences, Json* list) {
  const ExperimentOptions& experiment = report.results.experiment;
  for (std::size_t i = 0; i < experiment.compare.size(); ++i) {
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c) {
      const auto& difference = differences[i][c];
      if (!difference) continue;
      Json json = {{"a", experiment.compare[i].a},
                   {"b", experiment.compare[i].b},
                   {"condition", experiment.conditions[c].name},
                   {"metric", metric}};
      json.update(IntervalJson(*difference));
      list->push_back(std::move(json));
    }
  }
}

Json ComparisonsJson(const Report& report) {
  Json list = Json::array();
  AddComparisons(report, AccuracyMetric(report.results), report.differences, &list);
  AddComparisons(report, kSetsMetric, report.set_differences, &list);
  return list;
}

/// Of one angle of the poses alone, as bars show it.
Json AngleJson(const ExperimentResults& results, const Cell& cell, const ErrorMeasure& error_of) {
  return IntervalJson(
      BootstrapMean(SceneAccuracies(cell, results.experiment.tolerance(), error_of), BootstrapRng(results)));
}

Json CellJson(const ExperimentResults& results, const Cell& cell, const CellReport& report) {
  const ExperimentOptions& experiment = results.experiment;
  Json scenes = Json::object();
  for (const MetricValue& value : report.metrics) scenes[value.scene][value.metric] = NumberJson(value.value);
  const EstimatorRow& row = experiment.methods[cell.method];
  Json json = {{"condition", experiment.conditions[cell.condition].name},
               {"method", row.name},
               {"type", row.type},
               {"label", row.label},
               {"metrics", scenes},
               {AccuracyMetric(results) + "_ci95", IntervalJson(report.accuracy)},
               {"reference_minus_this", DifferenceJson(experiment, report)}};
  if (!std::isnan(report.sets.mean)) json[std::string(kSetsMetric) + "_ci95"] = IntervalJson(report.sets);
  const auto& bars = experiment.figures.bars;
  if (std::find(bars.begin(), bars.end(), row.name) != bars.end() && JudgesPoses(results) &&
      !JudgesStructures(results)) {
    json["rotation_ci95"] = AngleJson(results, cell, [](const EstimateError& error) { return error.rotation_deg; });
    json["translation_ci95"] =
        AngleJson(results, cell, [](const EstimateError& error) { return error.translation_deg; });
  }
  return json;
}

Json ConditionsJson(const ExperimentOptions& experiment) {
  Json list = Json::array();
  for (const Condition& one : experiment.conditions)
    list.push_back({{"name", one.name}, {"label", one.label}, {"value", KnownJson(one.value)}});
  return list;
}

Json MethodsJson(const ExperimentOptions& experiment) {
  Json list = Json::array();
  for (const EstimatorRow& row : experiment.methods)
    list.push_back({{"name", row.name}, {"label", row.label}, {"type", row.type}, {"competes", row.Competes()}});
  return list;
}

Json FiguresJson(const FigureOptions& figures) {
  Json budget = Json::array(), images = Json::array();
  for (const BudgetSeries& series : figures.budget)
    budget.push_back({{"label", series.label}, {"methods", series.methods}});
  for (const ImageFolder& folder : figures.images)
    images.push_back({{"scenes", folder.scenes}, {"folder", folder.folder}});
  return {{"curve", figures.curve}, {"bars", figures.bars}, {"budget", budget}, {"images", images}};
}

/// Each bin of each division, with the rows' accuracies by condition and method, as `results` has its cells.
Json StrataJson(const Report& report) {
  const ExperimentOptions& experiment = report.results.experiment;
  Json list = Json::array();
  for (const StrataReport& strata : report.strata) {
    Json rows = Json::array(), bins = Json::array();
    for (const std::size_t row : StrataRows(experiment, strata.options)) rows.push_back(experiment.methods[row].name);
    for (const StratumReport& one : strata.strata) {
      Json accuracies = Json::array();
      for (const ConfidenceInterval& accuracy : one.accuracies) accuracies.push_back(NumberJson(accuracy.mean));
      bins.push_back(
          {{"label", one.stratum.label}, {"problems", one.stratum.problems}, {"accuracies", std::move(accuracies)}});
    }
    list.push_back({{"by", ToString(strata.options.by)},
                    {"title", QuantityTitle(strata.options.by)},
                    {"rows", std::move(rows)},
                    {"bins", std::move(bins)}});
  }
  return list;
}

Json KnownIntervalJson(const std::optional<ConfidenceInterval>& interval) {
  return interval ? IntervalJson(*interval) : Json(nullptr);
}

/// What each level of each factor does, by condition.
Json EffectsJson(const Report& report) {
  const ExperimentOptions& experiment = report.results.experiment;
  Json list = Json::array();
  for (std::size_t f = 0; f < experiment.factors.size(); ++f) {
    Json levels = Json::array();
    for (std::size_t l = 0; l < experiment.factors[f].second.size(); ++l) {
      Json accuracy = Json::array(), milliseconds = Json::array();
      for (const FactorEffects& effects : report.effects) {
        accuracy.push_back(KnownIntervalJson(effects[f][l].accuracy));
        milliseconds.push_back(KnownIntervalJson(effects[f][l].milliseconds));
      }
      levels.push_back({{"level", experiment.factors[f].second[l]},
                        {"accuracy", std::move(accuracy)},
                        {"milliseconds", std::move(milliseconds)}});
    }
    list.push_back({{"factor", experiment.factors[f].first}, {"levels", std::move(levels)}});
  }
  return list;
}

Json TablesJson(const std::vector<Table>& tables) {
  Json list = Json::array();
  for (const Table& table : tables) {
    Json rows = Json::array();
    for (const Table::Row& row : table.rows)
      rows.push_back(
          {{"cells", row.cells}, {"best", row.best}, {"intervals", row.intervals}, {"from_paper", row.from_paper}});
    list.push_back({{"heading", table.heading}, {"columns", table.columns}, {"rows", std::move(rows)}});
  }
  return list;
}

Json PaperJson(const ExperimentResults& results) {
  Json rows = Json::object();
  for (const auto& [label, row] : results.experiment.paper)
    for (const auto& [condition, value] : row.values) {
      Json& json =
          rows[label][condition] = {{"mAA", KnownJson(value.accuracy)}, {"median_deg", KnownJson(value.median_deg)}};
      if (!value.rotation && !value.translation) continue;
      json["mAA_R"] = KnownJson(value.rotation);
      json["mAA_t"] = KnownJson(value.translation);
      json["median_R_deg"] = KnownJson(value.median_rotation_deg);
      json["median_t_deg"] = KnownJson(value.median_translation_deg);
    }
  return rows;
}

/// What a run's config.yaml begins with, "# key: value" lines, but for the program.
Json HeaderJson(const std::string& config) {
  Json header = Json::object();
  std::istringstream in(config);
  for (std::string line; std::getline(in, line) && line.starts_with("# ");) {
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos && !line.starts_with("# program"))
      header[line.substr(2, colon - 2)] = line.substr(colon + 2);
  }
  return header;
}

Json FactsJson(const RunFacts& facts, const std::string& config) {
  Json networks = Json::object();
  for (const auto& [path, digest] : facts.networks) networks[path] = digest;
  return {{"run", HeaderJson(config)},
          {"seconds", facts.seconds},
          {"peak_memory_mib", facts.peak_memory_mib},
          {"data_sha256", facts.data_digest},
          {"networks_sha256", networks}};
}

Json LearnedJson(const ExperimentResults& results) {
  Json rows = Json::object();
  for (const LearnedRow& row : results.learned)
    rows[results.experiment.methods[row.method].name] = {{"parameters", row.facts.parameters},
                                                         {"samples", row.facts.samples},
                                                         {"run_samples", row.facts.run_samples},
                                                         {"start", row.facts.start}};
  return rows;
}

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

std::string ResultsJson(const Report& report, const std::string& config) {
  const ExperimentResults& results = report.results;
  const ExperimentOptions& experiment = results.experiment;
  const Tolerance c = experiment.tolerance();
  Json cells = Json::array();
  for (const Cell& cell : results.cells) cells.push_back(CellJson(results, cell, report.Of(cell)));
  const Json json = {
      {"experiment", experiment.name},
      {"title", experiment.title},
      {"task", ToString(experiment.task)},
      {"dataset", results.dataset},
      {"seed", experiment.seed},
      {"seeds", results.seeds},
      {c.pixels ? "threshold_px" : "threshold_deg", c.value},
      {"partial", results.partial},
      {"left_out", experiment.left_out},
      {"git_revision", results.git_revision},
      {"machine", results.machine},
      {"learned", LearnedJson(results)},
      {"facts", FactsJson(results.facts, config)},
      {"setting", ReportSetting(results)},
      {"notes", ReportNotes(report)},
      {"experiment_notes", experiment.notes},
      {"report", experiment.report},
      {"accuracy", {{"metric", AccuracyMetric(results)}, {"title", AccuracyTitle(results)}}},
      {"unit", ShownUnit(JudgesStructures(results), c)},
      {"poses", JudgesPoses(results)},
      {"structures", JudgesStructures(results)},
      {"two_view", IsTwoView(experiment.task)},
      {"reference",
       ReferenceRow(experiment) < 0 ? Json(nullptr) : Json(experiment.methods[ReferenceRow(experiment)].name)},
      {"condition_label", experiment.condition_label},
      {"conditions", ConditionsJson(experiment)},
      {"methods", MethodsJson(experiment)},
      {"figures", FiguresJson(experiment.figures)},
      {"tables", TablesJson(report.tables)},
      {"strata", StrataJson(report)},
      {"effects", EffectsJson(report)},
      {"results", cells},
      {"differences", ComparisonsJson(report)},
      {"paper", PaperJson(results)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
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

}  // namespace diffsac
