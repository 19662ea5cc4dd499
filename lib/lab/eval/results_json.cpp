#include "lab/eval/run_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <utility>

#include "lab/eval/problem_quantities.h"

/// Null where it is not known; NaN becomes null when it is written.
template <class Value>
struct nlohmann::adl_serializer<std::optional<Value>> {
  template <class Json>
  static void to_json(Json& json, const std::optional<Value>& value) {
    json = value ? Json(*value) : Json(nullptr);
  }
};

namespace diffsac {

// What a value is in the file; nlohmann::json finds them by the values' types, in lists and optionals too.
namespace {
using Json = nlohmann::ordered_json;
}

static void to_json(Json& json, const ConfidenceInterval& interval) {
  json = {{"mean", interval.mean}, {"low", interval.low}, {"high", interval.high}};
}
static void to_json(Json& json, const Comparison& pair) { json = {pair.a, pair.b}; }
static void to_json(Json& json, const EstimatorRow& row) {
  json = {{"name", row.name}, {"label", row.label}, {"type", row.type}, {"competes", row.Competes()}};
}
static void to_json(Json& json, const BudgetSeries& series) {
  json = {{"label", series.label}, {"methods", series.methods}};
}
static void to_json(Json& json, const ImageFolder& folder) {
  json = {{"scenes", folder.scenes}, {"folder", folder.folder}};
}
static void to_json(Json& json, const FigureOptions& figures) {
  json = {{"curve", figures.curve}, {"bars", figures.bars}, {"budget", figures.budget}, {"images", figures.images}};
}
static void to_json(Json& json, const Table::Row& row) {
  json = {{"cells", row.cells}, {"best", row.best}, {"intervals", row.intervals}, {"from_paper", row.from_paper}};
}
static void to_json(Json& json, const Table& table) {
  json = {{"heading", table.heading}, {"columns", table.columns}, {"rows", table.rows}};
}

namespace {

// How much better the reference is on the same problems; null for itself and without ground truth.
Json DifferenceJson(const ExperimentOptions& experiment, const CellReport& cell) {
  if (!cell.reference_minus_this) return nullptr;
  Json json = {{"reference", experiment.methods[ReferenceRow(experiment)].name}};
  json.update(Json(*cell.reference_minus_this));
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
      json.update(Json(*difference));
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
  return BootstrapMean(SceneAccuracies(cell, results.experiment.tolerance(), error_of), BootstrapRng(results));
}

Json CellJson(const ExperimentResults& results, const Cell& cell, const CellReport& report) {
  const ExperimentOptions& experiment = results.experiment;
  Json scenes = Json::object();
  for (const MetricValue& value : report.metrics) scenes[value.scene][value.metric] = value.value;
  const EstimatorRow& row = experiment.methods[cell.method];
  Json json = {{"condition", experiment.conditions[cell.condition].name},
               {"method", row.name},
               {"type", row.type},
               {"label", row.label},
               {"metrics", scenes},
               {AccuracyMetric(results) + "_ci95", report.accuracy},
               {"reference_minus_this", DifferenceJson(experiment, report)}};
  if (!std::isnan(report.sets.mean)) json[std::string(kSetsMetric) + "_ci95"] = report.sets;
  const auto& bars = experiment.figures.bars;
  if (std::find(bars.begin(), bars.end(), row.name) != bars.end() && JudgesPoses(results) &&
      !JudgesInstances(results)) {
    json["rotation_ci95"] = AngleJson(results, cell, [](const EstimateError& error) { return error.rotation_deg; });
    json["translation_ci95"] =
        AngleJson(results, cell, [](const EstimateError& error) { return error.translation_deg; });
  }
  return json;
}

Json ConditionsJson(const ExperimentResults& results) {
  const std::vector<Condition>& conditions = results.experiment.conditions;
  Json list = Json::array();
  for (std::size_t c = 0; c < conditions.size(); ++c)
    list.push_back({{"name", conditions[c].name},
                    {"label", conditions[c].label},
                    {"value", conditions[c].value},
                    {"rows_share_problems", RowsShareProblems(results, c)}});
  return list;
}

/// What each level of each factor does, by condition.
Json EffectsJson(const ExperimentOptions& experiment, const std::vector<FactorEffects>& by_condition) {
  Json list = Json::array();
  for (std::size_t f = 0; f < experiment.factors.size(); ++f) {
    Json levels = Json::array();
    for (std::size_t l = 0; l < experiment.factors[f].second.size(); ++l) {
      Json accuracy = Json::array(), milliseconds = Json::array(), combinations = Json::array();
      for (const FactorEffects& effects : by_condition) {
        accuracy.push_back(effects[f][l].accuracy);
        milliseconds.push_back(effects[f][l].milliseconds);
        combinations.push_back(effects[f][l].combinations);
      }
      levels.push_back({{"level", experiment.factors[f].second[l]},
                        {"accuracy", std::move(accuracy)},
                        {"milliseconds", std::move(milliseconds)},
                        {"combinations", std::move(combinations)}});
    }
    list.push_back({{"factor", experiment.factors[f].first}, {"levels", std::move(levels)}});
  }
  return list;
}

/// One bin: the rows' accuracies by condition and method, as `results` has its cells, the comparisons by condition, the
/// effects.
Json BinJson(const ExperimentOptions& experiment, const StratumReport& one) {
  return {{"label", one.stratum.label},
          {"problems", one.stratum.problems},
          {"accuracies", one.accuracies},
          {"differences", one.differences},
          {"effects", EffectsJson(experiment, one.effects)}};
}

Json StrataJson(const Report& report) {
  const ExperimentOptions& experiment = report.results.experiment;
  Json list = Json::array();
  for (const StrataReport& strata : report.strata) {
    Json bins = Json::array(), rows = strata.options.rows;
    for (std::size_t m = 0; strata.options.rows.empty() && m < experiment.methods.size(); ++m)
      rows.push_back(experiment.methods[m].name);
    for (const StratumReport& one : strata.strata) bins.push_back(BinJson(experiment, one));
    list.push_back({{"by", ToString(strata.options.by)},
                    {"title", QuantityTitle(strata.options.by)},
                    {"rows", std::move(rows)},
                    {"bins", std::move(bins)},
                    {"unknown", strata.unknown}});
  }
  return list;
}

Json PaperJson(const ExperimentResults& results) {
  Json rows = Json::object();
  for (const auto& [label, row] : results.experiment.paper)
    for (const auto& [condition, value] : row.values) {
      Json& json = rows[label][condition] = {{"mAA", value.accuracy}, {"median_deg", value.median_deg}};
      if (!value.rotation && !value.translation) continue;
      json["mAA_R"] = value.rotation;
      json["mAA_t"] = value.translation;
      json["median_R_deg"] = value.median_rotation_deg;
      json["median_t_deg"] = value.median_translation_deg;
    }
  return rows;
}

/// One of the paper's metrics: its value, and the error that ours is made of; null: the task's main one.
struct PaperMetric {
  const char* name;
  std::optional<double> PaperValue::*paper;
  double EstimateError::*error;
};

constexpr PaperMetric kPaperMetrics[] = {{"mAA", &PaperValue::accuracy, nullptr},
                                         {"mAA of R", &PaperValue::rotation, &EstimateError::rotation_deg},
                                         {"mAA of t", &PaperValue::translation, &EstimateError::translation_deg}};

/// Ours with its interval and the number of problems beside each value of the paper's rows that name one of ours.
Json BesidePaperJson(const Report& report) {
  const ExperimentResults& results = report.results;
  const ExperimentOptions& experiment = results.experiment;
  Json rows = Json::array();
  for (const auto& [label, paper] : experiment.paper)
    for (std::size_t c = 0; c < experiment.conditions.size() && !paper.ours.empty(); ++c)
      for (const PaperMetric& metric : kPaperMetrics) {
        const auto value = paper.values.find(experiment.conditions[c].name);
        const Cell* cell = results.Find(c, experiment.RowOf(paper.ours));
        if (value == paper.values.end() || !(value->second.*metric.paper) || cell == nullptr) continue;
        Json ours = report.Of(*cell).accuracy;
        if (metric.error != nullptr)
          ours = AngleJson(results, *cell, [&](const EstimateError& error) { return error.*metric.error; });
        rows.push_back({{"method", paper.ours},
                        {"paper_row", label},
                        {"condition", c},
                        {"metric", metric.name},
                        {"paper", *(value->second.*metric.paper)},
                        {"ours", std::move(ours)},
                        {"problems", cell->records.size()}});
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

}  // namespace

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
      {"unit", ShownUnit(JudgesInstances(results), c)},
      {"poses", JudgesPoses(results)},
      {"structures", JudgesInstances(results)},
      {"two_view", IsTwoView(experiment.task)},
      {"reference",
       ReferenceRow(experiment) < 0 ? Json(nullptr) : Json(experiment.methods[ReferenceRow(experiment)].name)},
      {"condition_label", experiment.condition_label},
      {"conditions", ConditionsJson(results)},
      {"methods", experiment.methods},
      {"figures", experiment.figures},
      {"tables", report.tables},
      {"strata", StrataJson(report)},
      {"effects", EffectsJson(experiment, report.effects)},
      {"results", cells},
      {"differences", ComparisonsJson(report)},
      {"compare", experiment.compare},
      {"paper", PaperJson(results)},
      {"beside_paper", JudgesInstances(results) ? Json::array() : BesidePaperJson(report)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace diffsac
