#include "lab/eval/run_files.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <concepts>
#include <filesystem>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include "diffsac/core/former_names.h"
#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/eval/record_fields.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

/// One line of problems.csv, asked by the names of its columns.
class Line {
 public:
  Line(const std::vector<std::string>& names, std::vector<std::string> values)
      : names_(names), values_(std::move(values)) {
    if (values_.size() != names_.size())
      throw Error("expected " + std::to_string(names_.size()) + " values, found " + std::to_string(values_.size()));
  }
  bool Has(const char* name) const { return Find(name) != names_.end(); }
  const std::string& Text(const char* name) const {
    const auto found = Find(name);
    if (found == names_.end()) throw Error(std::string("no column '") + name + "'");
    return values_[static_cast<std::size_t>(found - names_.begin())];
  }
  double Number(const char* name) const {
    const std::string& text = Text(name);
    if (text.empty()) return std::numeric_limits<double>::quiet_NaN();
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (*end != '\0') throw Error(std::string(name) + ": '" + text + "' is no number");
    return value;
  }
  /// Numbers with a blank between them.
  std::vector<double> Numbers(const char* name) const {
    std::istringstream text(Text(name));
    std::vector<double> values;
    for (double value; text >> value;) values.push_back(value);
    if (!text.eof()) throw Error(std::string(name) + ": '" + Text(name) + "' is no list of numbers");
    return values;
  }
  int Count(const char* name) const {
    const double value = Number(name);
    if (!(value >= 0.0 && value < 2e9)) throw Error(std::string(name) + ": '" + Text(name) + "' is no count");
    return static_cast<int>(value);
  }

 private:
  /// By its current or its former name.
  std::vector<std::string>::const_iterator Find(const std::string& name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    return found != names_.end() ? found : std::find(names_.begin(), names_.end(), FormerName(name));
  }

  const std::vector<std::string>& names_;
  std::vector<std::string> values_;
};

/// Gives each number that is visited its column's value.
struct ReadValues {
  const Line& line;
  void operator()(const char* name, double& value) const { value = line.Number(Column(name)); }
  void operator()(const char* name, bool& value) const { value = line.Count(name) != 0; }
  template <std::integral Count>
  void operator()(const char* name, Count& value) const {
    value = line.Count(name);
  }
  void operator()(const char* name, Degeneracy& value) const { value = FromString<Degeneracy>(line.Text(name)); }
  void operator()(const char* name, std::vector<double>& values) const {
    if (line.Has(name)) values = line.Numbers(name);  // Runs of before have none.
  }
  /// The column's name, or what it was in files of earlier versions.
  const char* Column(const char* name) const {
    return std::string_view(name) == "ms_network" && !line.Has(name) ? "ms_denoise" : name;
  }
};

ProblemRecord RecordOf(const Line& line) {
  ProblemRecord record;
  record.id = line.Text("id");
  record.scene = line.Text("scene");
  record.status = StatusFromText(line.Text("status"));
  const ReadValues read{line};
  VisitRecord(record, read);
  if (line.Has("log10_nfa")) VisitChance(record, read);
  if (line.Has("inlier_share")) VisitQuantities(record, read);
  if (line.Has("rotation_level")) VisitLevels(record, read);
  if (line.Has("pose_deg")) VisitPose(record, read);
  if (line.Has("recall")) VisitInstances(record, read);
  record.done = true;
  return record;
}

template <class Named>
std::size_t IndexOf(const std::vector<Named>& all, const std::string& name, const char* what) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Named& one) { return one.name == name; });
  if (found == all.end()) throw Error(std::string("config.yaml has no ") + what + " '" + name + "'");
  return static_cast<std::size_t>(found - all.begin());
}

void AddRecord(const Line& line, std::vector<std::map<std::string, std::uint64_t>>* problems,
               ExperimentResults* results) {
  const ExperimentOptions& experiment = results->experiment;
  const std::size_t condition = IndexOf(experiment.conditions, line.Text("condition"), "condition"),
                    method = IndexOf(experiment.methods, line.Text("method"), "method");
  ProblemRecord record = RecordOf(line);
  auto& known = (*problems)[condition];
  record.index = known.try_emplace(record.scene + "\n" + record.id, known.size()).first->second;
  auto& cells = results->cells;
  if (cells.empty() || cells.back().condition != condition || cells.back().method != method)
    cells.push_back({condition, method, {}});
  cells.back().records.push_back(std::move(record));
}

void ReadProblems(const std::string& path, ExperimentResults* results) {
  const std::string text = ReadFile(path);
  std::vector<std::map<std::string, std::uint64_t>> problems(results->experiment.conditions.size());
  std::size_t at = 0, number = 1;
  const std::vector<std::string> names = TakeCsvLine(text, &at);
  try {
    for (++number; at < text.size(); ++number) AddRecord(Line(names, TakeCsvLine(text, &at)), &problems, results);
  } catch (const Error& error) {
    throw Error(path + ":" + std::to_string(number) + ": " + error.what());
  }
  for (const auto& known : problems) results->problems.push_back(known.size());
}

RunFacts FactsOf(const nlohmann::json& json) {
  RunFacts facts{json.at("seconds").get<double>(),
                 json.at("peak_memory_mib").get<double>(),
                 json.at("data_sha256").get<std::string>(),
                 {}};
  for (const auto& [path, digest] : json.at("networks_sha256").items())
    facts.networks.emplace_back(path, digest.get<std::string>());
  return facts;
}

LearnedRow LearnedRowOf(const nlohmann::json& facts, std::size_t method) {
  LearnedRow row{method, {}};
  row.facts.parameters = facts.at("parameters").get<std::int64_t>();
  row.facts.samples = facts.at("samples").get<std::int64_t>();
  row.facts.run_samples = facts.at("run_samples").get<std::int64_t>();
  row.facts.start = facts.at("start").get<std::string>();
  return row;
}

void ReadFacts(const std::string& path, ExperimentResults* results) {
  const auto json = nlohmann::json::parse(ReadFile(path), nullptr, false);
  try {
    results->dataset = json.at("dataset").get<std::string>();
    results->experiment.left_out = json.value("left_out", std::vector<std::string>());
    results->partial = json.at("partial").get<bool>();
    results->git_revision = json.at("git_revision").get<std::string>();
    results->machine = json.at("machine").get<std::string>();
    results->seeds = json.value("seeds", std::vector<std::uint64_t>());
    if (json.contains("facts")) results->facts = FactsOf(json.at("facts"));
    const nlohmann::json learned = json.value("learned", nlohmann::json::object());
    for (const auto& [name, facts] : learned.items())
      results->learned.push_back(LearnedRowOf(facts, results->experiment.RowOf(name)));
  } catch (const nlohmann::json::exception&) {
    throw Error(path + ": not the results.json of a run, or damaged");
  }
}

}  // namespace

ExperimentResults ReadRun(const std::string& folder) {
  const fs::path path(folder);
  if (!fs::is_directory(path)) throw Error("no folder '" + folder + "'");
  for (const char* name : {"config.yaml", "results.json", "problems.csv"})
    if (!fs::exists(path / name)) throw Error("'" + folder + "' holds no whole run of diffsac_eval: no " + name);
  ExperimentResults results;
  results.experiment = ReadExperiment(ConfigFromFile((path / "config.yaml").string()));
  ReadFacts((path / "results.json").string(), &results);
  ReadProblems((path / "problems.csv").string(), &results);
  return results;
}

}  // namespace diffsac
