#include "lab/eval/run_files.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <utility>

#include "lab/eval/format.h"
#include "lab/eval/record_fields.h"
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
  void operator()(const char*, Degeneracy translation) const { *text += "," + std::string(ToString(translation)); }
  void operator()(const char*, const std::vector<double>& values) const {
    *text += ",";
    for (std::size_t i = 0; i < values.size(); ++i) *text += (i == 0 ? "" : " ") + NumberText(values[i]);
  }
  // All digits: far from the origin, nine of a normal are not enough.
  void operator()(const char*, const ModelParameters& model) const {
    *text += ",";
    for (Eigen::Index i = 0; i < model.size(); ++i) *text += (i == 0 ? "" : " ") + ShortestNumber(model[i]);
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

/// The lines of results.csv: experiment,dataset,scene,condition,method,metric,value.
class LongLines {
 public:
  explicit LongLines(const ExperimentResults& results) : results_(results), accuracy_(AccuracyMetric(results)) {}
  void Add(const std::string& scene, std::size_t condition, const std::string& method, const std::string& metric,
           double value) {
    text_ += CsvText(results_.experiment.name) + "," + CsvText(results_.dataset) + "," + CsvText(scene) + "," +
             CsvText(results_.experiment.conditions[condition].name) + "," + CsvText(method) + "," + metric + "," +
             NumberText(value) + "\n";
  }
  /// The mean under the metric's name and, where they are known, the ends under METRIC_low and METRIC_high.
  void Add(const std::string& scene, std::size_t condition, const std::string& method, const std::string& metric,
           const ConfidenceInterval& interval) {
    Add(scene, condition, method, metric, interval.mean);
    if (std::isnan(interval.low)) return;
    Add(scene, condition, method, metric + "_low", interval.low);
    Add(scene, condition, method, metric + "_high", interval.high);
  }
  const ExperimentResults& results() const { return results_; }
  /// AccuracyMetric.
  const std::string& accuracy() const { return accuracy_; }
  const std::string& text() const { return text_; }

 private:
  const ExperimentResults& results_;
  std::string accuracy_;
  std::string text_ = "experiment,dataset,scene,condition,method,metric,value\n";
};

void AddStratumRows(const StratumReport& one, LongLines* lines) {
  const ExperimentResults& results = one.stratum.results;
  for (std::size_t i = 0; i < results.cells.size(); ++i) {
    const Cell& cell = results.cells[i];
    if (cell.records.empty()) continue;
    const std::string& method = results.experiment.methods[cell.method].name;
    const auto failures = std::count_if(cell.records.begin(), cell.records.end(),
                                        [](const ProblemRecord& record) { return record.error.failed; });
    lines->Add(one.stratum.name, cell.condition, method, lines->accuracy(), one.accuracies[i]);
    lines->Add(one.stratum.name, cell.condition, method, "problems", static_cast<double>(cell.records.size()));
    lines->Add(one.stratum.name, cell.condition, method, "failures", static_cast<double>(failures));
  }
}

void AddStratumDifferences(const StratumReport& one, LongLines* lines) {
  const ExperimentOptions& experiment = one.stratum.results.experiment;
  for (std::size_t i = 0; i < experiment.compare.size(); ++i)
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c)
      if (const auto& difference = one.differences[i][c])
        lines->Add(one.stratum.name, c, experiment.compare[i].a + " - " + experiment.compare[i].b, lines->accuracy(),
                   *difference);
}

/// Effects by condition: "FACTOR=LEVEL" in the method's place, the accuracy's metric and `ms` with their ends, and
/// `combinations`.
void AddEffectLines(const std::vector<FactorEffects>& effects, const std::string& scene, LongLines* lines) {
  const ExperimentOptions& experiment = lines->results().experiment;
  for (std::size_t c = 0; c < effects.size(); ++c)
    for (std::size_t f = 0; f < effects[c].size(); ++f)
      for (std::size_t l = 0; l < effects[c][f].size(); ++l) {
        const LevelEffect& effect = effects[c][f][l];
        const std::string method = experiment.factors[f].first + "=" + experiment.factors[f].second[l];
        if (effect.accuracy) lines->Add(scene, c, method, lines->accuracy(), *effect.accuracy);
        if (effect.milliseconds) lines->Add(scene, c, method, "ms", *effect.milliseconds);
        lines->Add(scene, c, method, "combinations", static_cast<double>(effect.combinations));
      }
}

/// For each stratum, its name in the scene's place: of each row the accuracy with its ends, problems and failures; the
/// comparisons, "A - B" in the method's place; the effects.
void AddStrataLines(const Report& report, LongLines* lines) {
  for (const StrataReport& strata : report.strata) {
    if (!strata.known()) continue;
    for (const StratumReport& one : strata.strata) {
      AddStratumRows(one, lines);
      AddStratumDifferences(one, lines);
      AddEffectLines(one.effects, one.stratum.name, lines);
    }
  }
}

std::vector<std::string> ConditionNames(const ExperimentOptions& experiment) {
  std::vector<std::string> names;
  for (const Condition& condition : experiment.conditions) names.push_back(condition.name);
  return names;
}

/// What programs leave, in the order of use, and what it is for.
constexpr std::pair<const char*, const char*> kFiles[] = {
    {"report.html", " (open it in a browser)"},
    {"checkpoints/best.safetensors", " (the network, for --checkpoint)"},
    {"table.md", ""},
    {"problems.csv", ""},
    {"estimates.h5", ""},
    {"metrics.csv", ""},
    {"events.out.tfevents.diffsac", " (tensorboard --logdir of the folder)"},
    {"labels", " (the points with their labels)"},
};

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
  const bool two_view = IsTwoView(results.experiment.task), instances = JudgesInstances(results);
  const auto visit = [&](const ProblemRecord& record, const auto& append) {
    VisitRecord(record, append);
    VisitEstimate(record, append);
    VisitChance(record, append);
    VisitQuantities(record, append);
    VisitLevels(record, append);
    if (two_view) VisitPose(record, append);
    if (instances) VisitInstances(record, append);
  };
  std::string text = "id,scene,condition,method,status";
  visit(ProblemRecord(), AppendNames{&text});
  text += "\n";
  for (const Cell& cell : results.cells) {
    const std::string names = "," + CsvText(results.experiment.conditions[cell.condition].name) + "," +
                              CsvText(results.experiment.methods[cell.method].name) + ",";
    for (const ProblemRecord& record : cell.records) {
      text += CsvText(record.id) + "," + CsvText(record.scene) + names + std::string(ToString(record.status));
      visit(record, AppendValues{&text});
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

std::string ResultsText(const std::string& folder) {
  std::string files;
  for (const auto& [name, purpose] : kFiles)
    if (std::filesystem::exists(std::filesystem::path(folder) / name))
      files += (files.empty() ? ": " : ", ") + std::string(name) + purpose;
  return "results are in " + folder + files;
}

}  // namespace diffsac
