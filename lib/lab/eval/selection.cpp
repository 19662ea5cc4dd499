#include "lab/eval/selection.h"

#include <algorithm>

#include "diffsac/core/status.h"
#include "lab/config/paths.h"
#include "lab/options/config_tree.h"

namespace diffsac {
namespace {

void AddOnce(const std::string& text, std::vector<std::string>* texts) {
  if (std::find(texts->begin(), texts->end(), text) == texts->end()) texts->push_back(text);
}

std::vector<std::string> PathsOf(const Condition& condition) {
  std::vector<std::string> paths;
  for (const Config& path : condition.data.Sequence("paths")) paths.push_back(path.Text());
  if (condition.data.Has("root")) paths.push_back(condition.data.Text("root"));
  return paths;
}

std::string FileOf(const EstimatorRow& row) {
  for (const char* key : {"recording", "checkpoint"})
    if (row.config.Has(key)) return row.config.Text(key);
  return "";
}

/// Of the list `paths` those that are there; in a document of its own, for copies of an experiment share theirs.
void KeepPaths(Condition* condition) {
  Config kept = condition->data.MergedWith({});
  if (ConfigTree* paths = kept.impl_->document->root.Find("paths"))
    std::erase_if(paths->items, [](const ConfigTree& path) { return !IsThere(path.scalar); });
  condition->data = kept;
}

/// Rows whose conditions are all gone; one that names none is for all of those that are left.
void RemoveRowsFor(const std::string& condition, ExperimentOptions* experiment) {
  std::vector<std::string> kept;
  for (EstimatorRow& row : experiment->methods) {
    if (std::erase(row.conditions, condition) > 0 && row.conditions.empty())
      experiment->left_out.push_back(row.label + " (none of its conditions is left)");
    else
      kept.push_back(row.name);
  }
  if (!kept.empty()) SelectEstimators(kept, experiment);
  if (kept.empty()) experiment->methods.clear();
}

void LeaveOutData(ExperimentOptions* experiment) {
  std::vector<std::string> lost;
  for (Condition& condition : experiment->conditions) {
    const std::vector<std::string> paths = PathsOf(condition);
    const auto there = static_cast<std::size_t>(std::count_if(paths.begin(), paths.end(), IsThere));
    if (there == paths.size()) continue;
    const auto absent = std::find_if_not(paths.begin(), paths.end(), IsThere);
    if (there == 0) {
      lost.push_back(condition.name);
      experiment->left_out.push_back(condition.label + " (needs " + *absent + ")");
      continue;
    }
    for (const std::string& path : paths)
      if (!IsThere(path)) AddOnce(path + " (not there)", &experiment->left_out);
    KeepPaths(&condition);
  }
  for (const std::string& name : lost) {
    std::erase_if(experiment->conditions, [&](const Condition& condition) { return condition.name == name; });
    RemoveRowsFor(name, experiment);
  }
}

void LeaveOutRows(ExperimentOptions* experiment) {
  std::vector<std::string> kept;
  for (const EstimatorRow& row : experiment->methods) {
    const std::string file = FileOf(row);
    if (file.empty() || IsThere(file))
      kept.push_back(row.name);
    else
      experiment->left_out.push_back(row.label + " (needs " + file + ")");
  }
  if (kept.empty()) experiment->methods.clear();
  SelectEstimators(kept, experiment);
}

}  // namespace

void SelectEstimators(const std::vector<std::string>& names, ExperimentOptions* experiment) {
  if (names.empty()) return;
  std::vector<std::string> known;
  for (const EstimatorRow& row : experiment->methods) known.push_back(row.name);
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error("--methods: no method is named '" + name + "'; did you mean '" + NearestWord(name, known) +
                  "'? The configuration has " + Listed(known));
  }
  std::erase_if(experiment->methods, [&](const EstimatorRow& row) {
    return std::find(names.begin(), names.end(), row.name) == names.end();
  });
}

std::vector<std::string> DataPaths(const ExperimentOptions& experiment) {
  std::vector<std::string> all;
  for (const Condition& condition : experiment.conditions)
    for (const std::string& path : PathsOf(condition)) AddOnce(path, &all);
  return all;
}

std::vector<std::string> RowFiles(const ExperimentOptions& experiment) {
  std::vector<std::string> all;
  for (const EstimatorRow& row : experiment.methods)
    if (const std::string file = FileOf(row); !file.empty()) AddOnce(file, &all);
  return all;
}

bool LeaveOutMissing(bool any_checkpoint, ExperimentOptions* experiment) {
  if (experiment->missing == Missing::kLeaveOut) {
    LeaveOutData(experiment);
    if (!any_checkpoint) LeaveOutRows(experiment);
  }
  return !experiment->conditions.empty() && !experiment->methods.empty();
}

std::string NothingIsHere(const ExperimentOptions& experiment) {
  return experiment.name + ": skipped, nothing of it is here: " + experiment.left_out.front();
}

ExperimentOptions WithResolvedRows(ExperimentOptions experiment, const EstimatorContext& context) {
  for (EstimatorRow& row : experiment.methods) row.config = ResolvedRow(row.config, experiment.task, context);
  return experiment;
}

}  // namespace diffsac
