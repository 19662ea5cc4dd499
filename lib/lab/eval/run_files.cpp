#include "lab/eval/run_files.h"

#include <cmath>
#include <concepts>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "diffsac/core/status.h"
#include "lab/config/run_directory.h"
#include "lab/config/yaml.h"
#include "lab/eval/format.h"
#include "lab/files/files.h"
#include "lab/options/config.h"

namespace diffsac {
namespace {

using Json = nlohmann::ordered_json;

/// Which columns there are.
struct ColumnKinds {
  bool estimates = true, two_view = false, instances = false;
};

/// Visits the numbers of a record by the names of their columns, in their order: visit(name, value). The truth's
/// quantities are told in problem_quantities.h, those of several structures in instances_error.h.
template <class Visit>
void VisitRecord(const ProblemRecord& r, const ColumnKinds& kinds, const Visit& visit) {
  visit("angle_deg", r.error.angle_deg);
  visit("offset", r.error.offset);
  visit("rotation_deg", r.error.rotation_deg);
  visit("translation_deg", r.error.translation_deg);
  visit("error_px", r.error.error_px);
  visit("focal_error", r.error.focal);
  visit("inliers", r.inliers);
  visit("hypotheses", r.stats.hypotheses);
  visit("ms_features", r.stats.ms_features);
  visit("ms_network", r.stats.ms_network);
  visit("ms_consensus", r.stats.ms_consensus);
  visit("ms_total", r.stats.ms_total);
  visit("points", r.points);
  visit("failed", r.error.failed);
  visit("unique_minimal_sets", r.stats.unique_minimal_sets);
  visit("all_inlier_sets", r.all_inlier_sets);
  constexpr const char* kPose[] = {"qw", "qx", "qy", "qz", "tx", "ty", "tz"};
  static const EstimateRecord kNone;  // Of examples alone there are others.
  const EstimateRecord& found = kinds.estimates ? r : kNone;
  visit("sigma", std::isfinite(found.sigma) ? found.sigma : std::nan(""));
  const std::array<double, 7> pose = PoseNumbers(found.pose);
  for (std::size_t i = 0; i < pose.size(); ++i) visit(kPose[i], pose[i]);
  visit("model", found.model);
  visit("log10_nfa", r.log10_nfa);
  visit("inlier_share", r.inlier_share);
  visit("true_rotation_deg", r.true_rotation_deg);
  visit("true_baseline", r.true_baseline);
  visit("true_parallax_deg", r.true_parallax_deg);
  visit("rotation_level", r.levels.rotation);
  visit("translation_level", r.levels.translation);
  if (kinds.two_view) {
    visit("pose_rotation_deg", r.error.pose_rotation_deg);
    visit("pose_translation_deg", r.error.pose_translation_deg);
    visit("pose_deg", r.error.pose_deg);
    visit("degeneracy", r.degeneracy);
    visit("has_ambiguous_pose", r.has_ambiguous_pose);
    visit("error_probability", r.error_probability);
  }
  if (kinds.instances) {
    visit("misclassified", r.error.misclassified);
    visit("recall", r.error.recall);
    visit("one_structure_sets", r.one_instance_sets);
    visit("structures_in_sets", r.instances_in_sets);
    visit("structures", r.instance_count);
    visit("draws", r.stats.iterations);
    visit("structure_angles_deg", r.error.instance_angles_deg);
  }
  visit("largest_coordinate", r.largest_coordinate);
}

std::string FieldText(double value) {
  return std::isnan(value) ? "" : std::isinf(value) ? (value > 0 ? "inf" : "-inf") : ShortestNumber(value);
}
std::string FieldText(std::integral auto count) { return std::to_string(count); }
std::string FieldText(Degeneracy translation) { return ToString(translation); }
template <class Values>
requires requires(const Values& values) { values.begin(); }
std::string FieldText(const Values& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : " ") + FieldText(value);
  return text;
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

Json ConditionsJson(const ExperimentResults& results) {
  Json list = Json::array();
  for (std::size_t c = 0; c < results.experiment.conditions.size(); ++c) {
    const Condition& condition = results.experiment.conditions[c];
    list.push_back({{"name", condition.name},
                    {"label", condition.label},
                    {"value", condition.value ? Json(*condition.value) : Json(nullptr)},
                    {"problems", c < results.problems.size() ? results.problems[c] : 0}});
  }
  return list;
}

Json MethodsJson(const ExperimentOptions& experiment) {
  Json list = Json::array();
  for (const EstimatorRow& row : experiment.methods)
    list.push_back({{"name", row.name},
                    {"label", row.label},
                    {"type", row.type},
                    {"competes", row.Competes()},
                    {"conditions", row.conditions},
                    {"max_problems", row.max_problems}});
  return list;
}

Json ReliabilityJson(const std::vector<Reliability>& all) {
  Json list = Json::array();
  for (const Reliability& one : all)
    list.push_back({{"label", one.label}, {"condition", one.condition}, {"scenes", one.scenes}});
  return list;
}

Json ConfigurationJson(const std::string& yaml) { return Json::parse(ToJson(ConfigFromYaml(yaml))); }

std::string TextOf(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json SetupJson(const RunSetup& setup) { return {{"checkpoint", setup.checkpoint}, {"device", setup.device}}; }

Json ShardJson(const Shard& shard) {
  return shard.whole() ? Json(nullptr) : Json{{"index", shard.index}, {"count", shard.count}};
}

}  // namespace

std::string ProblemsCsv(const ExperimentResults& results) {
  const ExperimentOptions& experiment = results.experiment;
  const ColumnKinds kinds{experiment.estimates, IsTwoView(experiment.task), JudgesInstances(results)};
  std::string text = "index,id,scene,condition,method,status";
  VisitRecord(ProblemRecord(), kinds, [&](const char* name, const auto&) { text += std::string(",") + name; });
  text += "\n";
  for (const Cell& cell : results.cells) {
    const std::string names = "," + CsvText(experiment.conditions[cell.condition].name) + "," +
                              CsvText(experiment.methods[cell.method].name) + ",";
    for (const ProblemRecord& record : cell.records) {
      text += std::to_string(record.index) + "," + CsvText(record.id) + "," + CsvText(record.scene) + names +
              std::string(ToString(record.status));
      VisitRecord(record, kinds, [&](const char*, const auto& value) { text += "," + FieldText(value); });
      text += "\n";
    }
  }
  return text;
}

std::string RunJson(const ExperimentResults& results, const RunSetup& setup, const std::string& config) {
  const ExperimentOptions& experiment = results.experiment;
  const Tolerance c = experiment.tolerance();
  return TextOf({{"format", "diffsac run 1"},
                 {"experiment", experiment.name},
                 {"task", ToString(experiment.task)},
                 {"dataset", results.dataset},
                 {"seed", experiment.seed},
                 {c.pixels ? "threshold_px" : "threshold_deg", c.value},
                 {"unit", JudgesInstances(results) ? "%"
                          : c.pixels               ? "px"
                                                   : "°"},
                 {"two_view", IsTwoView(experiment.task)},
                 {"partial", results.partial},
                 {"shard", ShardJson(results.shard)},
                 {"setup", SetupJson(setup)},
                 {"left_out", experiment.left_out},
                 {"conditions", ConditionsJson(results)},
                 {"methods", MethodsJson(experiment)},
                 {"git_revision", GitRevision()},
                 {"machine", MachineText()},
                 {"learned", LearnedJson(results)},
                 {"facts", FactsJson(results.facts, config)},
                 {"reliability", ReliabilityJson(results.reliability)},
                 {"configuration", ConfigurationJson(config)}});
}

std::string SeedFolder(int seed) { return "seed_" + std::to_string(seed); }

std::string SeedsJson(const ExperimentOptions& experiment, const std::vector<int>& seeds) {
  std::vector<std::string> folders;
  for (const int seed : seeds) folders.push_back(SeedFolder(seed));
  return TextOf({{"format", "diffsac runs 1"},
                 {"experiment", experiment.name},
                 {"task", ToString(experiment.task)},
                 {"seeds", seeds},
                 {"folders", folders},
                 {"partial", false},
                 {"configuration", ConfigurationJson(WriteExperiment(experiment))}});
}

void WriteRun(const ExperimentResults& results, const RunSetup& setup, const std::string& folder) {
  WriteFileAtomically(folder + "/problems.csv", ProblemsCsv(results));
  WriteEstimates(results, folder);
  WriteFileAtomically(folder + "/" + kRunFile, RunJson(results, setup, ReadFile(folder + "/config.yaml")));
}

bool IsMade(const ExperimentOptions& experiment, const RunSetup& setup, const Shard& shard, const std::string& folder) {
  const std::string config = folder + "/config.yaml", run = folder + "/" + kRunFile;
  for (const std::string& path : {config, run, folder + "/problems.csv"})
    if (!std::filesystem::exists(path)) return false;
  try {
    const Json json = Json::parse(ReadFile(run));
    if (json.at("partial") != false || json.at("setup") != SetupJson(setup) || json.at("shard") != ShardJson(shard))
      return false;
    if (WriteMeasured(ReadExperiment(ConfigFromFile(config))) != WriteMeasured(experiment)) return false;
  } catch (const Error&) {
    return false;
  } catch (const Json::exception&) {
    return false;  // Of an earlier version, or damaged.
  }
  std::vector<std::filesystem::path> sources = {std::filesystem::read_symlink("/proc/self/exe")};
  for (const EstimatorRow& row : experiment.methods)
    if (row.config.Has("checkpoint")) sources.emplace_back(row.config.Text("checkpoint"));
  return std::all_of(sources.begin(), sources.end(), [&](const std::filesystem::path& source) {
    return std::filesystem::exists(source) &&
           std::filesystem::last_write_time(source) < std::filesystem::last_write_time(run);
  });
}

void UpdateCaptions(const ExperimentOptions& experiment, const std::string& folder) {
  const std::string path = folder + "/config.yaml", run = folder + "/" + kRunFile;
  const std::string config = ReadFile(path), own = WriteExperiment(experiment);
  const std::size_t body = config.find("\n\n") + 2;
  if (config.compare(body, std::string::npos, own) == 0) return;
  try {
    Json json = Json::parse(ReadFile(run));
    json["configuration"] = ConfigurationJson(own);
    for (std::size_t m = 0; m < experiment.methods.size(); ++m)
      json.at("methods").at(m).at("label") = experiment.methods[m].label;
    for (std::size_t c = 0; c < experiment.conditions.size(); ++c)
      json.at("conditions").at(c).at("label") = experiment.conditions[c].label;
    WriteFileAtomically(path, config.substr(0, body) + own);
    WriteFileAtomically(run, TextOf(json));
  } catch (const Json::exception&) {
    throw Error(run + ": not the run.json of this run, or damaged");
  }
}

Shard ShardFromText(const std::string& text) {
  Shard shard;
  char more = '\0';
  const int read = std::sscanf(text.c_str(), "%9d/%9d%c", &shard.index, &shard.count, &more);
  const bool plain = text.find_first_not_of("0123456789/") == std::string::npos;
  if (!plain || read != 2 || shard.index < 1 || shard.index > shard.count)
    throw Error("--shard: expected i/n with 1 <= i <= n, as in 2/3; got '" + text + "'");
  return shard;
}

}  // namespace diffsac
