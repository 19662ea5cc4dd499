#include "lab/config/compose.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/config/paths.h"
#include "lab/config/tree_edits.h"
#include "lab/options/config_tree.h"

namespace diffsac {
namespace {

constexpr const char* kDefaultDataRoot = "data";

std::string TextOf(const ConfigTree& map, const std::string& key) {
  const ConfigTree* value = map.Find(key);
  return value == nullptr ? "" : value->scalar;
}

/// Puts values of the experiment in the place of ${key.path}.
void Interpolate(const ConfigTree& experiment, ConfigTree* tree) {
  for (std::size_t at = 0; (at = tree->scalar.find("${", at)) != std::string::npos;) {
    const std::size_t end = tree->scalar.find('}', at);
    if (end == std::string::npos) FailAt(*tree, tree->scalar, "'${' without '}'");
    const std::string path = tree->scalar.substr(at + 2, end - at - 2);
    const ConfigTree* value = &experiment;
    for (const std::string& step : SplitPath(path)) value = value == nullptr ? nullptr : value->Find(step);
    if (value == nullptr || value->kind != TreeKind::kScalar)
      FailAt(*tree, "${" + path + "}", "expected a key of this file that has a plain value");
    if (value->scalar.find("${") != std::string::npos)
      FailAt(*tree, "${" + path + "}", "its value must stand there itself, without '${'");
    // A path that begins with --data-root is relative to the current folder, not to the file that goes on with it.
    if (at == 0 && !value->place.assignment.empty()) tree->place = value->place;
    tree->scalar.replace(at, end + 1 - at, value->scalar);
    at += value->scalar.size();
  }
  for (ConfigTree& item : tree->items) Interpolate(experiment, &item);
  for (ConfigEntry& entry : tree->entries) Interpolate(experiment, &entry.value);
}

/// A condition for each value of one option of the data.
ConfigTree SweptConditions(const ConfigTree& sweep) {
  if (sweep.kind != TreeKind::kMap || sweep.entries.size() != 1 || sweep.entries[0].value.kind != TreeKind::kSequence)
    FailAt(sweep, "sweep", "expected an option of the data and its values, {outlier_ratio: [0.1, 0.2]}");
  const auto& [key, values] = sweep.entries[0];
  if (key == "seed") FailAt(sweep, "sweep", "seeds are whole runs, 'seeds: [1, 2]'");
  ConfigTree conditions = ListAt(sweep);
  for (const ConfigTree& value : values.items) {
    if (value.kind != TreeKind::kScalar) FailAt(value, "sweep", "expected plain values");
    ConfigTree condition, data;
    condition.place = data.place = value.place;
    PutIn(&data, key, value);
    PutIn(&condition, "name", ScalarAt(value, value.scalar));
    PutIn(&condition, "value", value);
    PutIn(&condition, "data", std::move(data));
    conditions.items.push_back(std::move(condition));
  }
  return conditions;
}

/// Puts rows on the settings that they use.
class Settings {
 public:
  explicit Settings(ConfigTree settings) : settings_(std::move(settings)) {
    if (settings_.kind != TreeKind::kNull && settings_.kind != TreeKind::kMap)
      FailAt(settings_, "settings", "expected a map of named parts of rows");
  }

  ConfigTree Resolve(ConfigTree part, int depth = 0) const {
    const ConfigTree use = Take(&part, "use");
    if (use.kind == TreeKind::kNull) return part;
    if (depth > kMostNested) FailAt(use, "use", "settings that use each other in a circle");
    ConfigTree base;
    base.kind = TreeKind::kMap;
    for (const std::string& name : Words(use, "use")) {
      const ConfigTree* setting = settings_.Find(name);
      if (setting == nullptr) FailAt(use, "use", "no setting is named '" + name + "'" + Nearest(name));
      if (setting->kind != TreeKind::kMap) FailAt(*setting, "settings." + name, "expected a map, part of a row");
      MergeTrees(base, Resolve(*setting, depth + 1));
    }
    MergeTrees(base, std::move(part));
    return base;
  }

 private:
  static constexpr int kMostNested = 16;

  std::string Nearest(const std::string& name) const {
    std::vector<std::string> known;
    for (const ConfigEntry& entry : settings_.entries) known.push_back(entry.key);
    return known.empty() ? "" : "; did you mean '" + NearestWord(name, known) + "'?";
  }

  ConfigTree settings_;
};

/// The rows of a map by name, as a list.
ConfigTree NamedRows(ConfigTree methods) {
  if (methods.kind != TreeKind::kMap) return methods;
  ConfigTree rows = ListAt(methods);
  for (ConfigEntry& entry : methods.entries) {
    if (entry.value.kind != TreeKind::kMap) FailAt(entry.value, "methods." + entry.key, "expected a map {type, ...}");
    if (entry.value.Find("name") != nullptr)
      FailAt(entry.value, "methods." + entry.key, "has its name already, without the key 'name'");
    ConfigTree row;
    row.place = entry.value.place;
    PutIn(&row, "name", ScalarAt(entry.value, entry.key));
    MergeTrees(row, std::move(entry.value));
    rows.items.push_back(std::move(row));
  }
  return rows;
}

/// The oracle, which is a ceiling and no competitor, last.
ConfigTree WithOracleLast(ConfigTree rows) {
  std::stable_partition(rows.items.begin(), rows.items.end(),
                        [](const ConfigTree& row) { return TextOf(row, "type") != "oracle"; });
  return rows;
}

/// The named rows in that order.
ConfigTree Chosen(const ConfigTree& rows, const ConfigTree& names) {
  std::vector<std::string> known;
  for (const ConfigTree& row : rows.items) known.push_back(TextOf(row, "name"));
  ConfigTree chosen = ListAt(rows);
  for (const std::string& name : Words(names, "rows")) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      FailAt(names, "rows", "no method is named '" + name + "'; did you mean '" + NearestWord(name, known) + "'?");
    chosen.items.push_back(rows.items[static_cast<std::size_t>(found - known.begin())]);
  }
  return chosen;
}

ConfigTree ComposeEstimators(const ConfigTree& methods, ConfigTree settings, const ConfigTree& names) {
  const ConfigTree listed = NamedRows(methods);
  if (listed.kind != TreeKind::kSequence) return listed;  // Its reader says what was expected.
  const Settings known(std::move(settings));
  ConfigTree resolved = ListAt(listed);
  for (const ConfigTree& row : listed.items)
    resolved.items.push_back(row.kind == TreeKind::kMap ? known.Resolve(row) : row);
  // A list has its author's order; a map may come from several files.
  if (methods.kind == TreeKind::kMap) resolved = WithOracleLast(std::move(resolved));
  return names.kind == TreeKind::kNull ? resolved : Chosen(resolved, names);
}

}  // namespace

Config ComposeExperiment(const Config& config) {
  const ConfigTree* given = config.impl_->Get();
  Config composed;
  ConfigTree& root = composed.impl_->document->root;
  if (given != nullptr) root = *given;
  if (root.kind == TreeKind::kNull) root.kind = TreeKind::kMap;
  if (root.kind != TreeKind::kMap) return composed;
  if (root.Find("data_root") == nullptr) PutIn(&root, "data_root", ScalarAt(root, kDefaultDataRoot));
  const ConfigTree* seeds = root.Find("seeds");
  if (seeds != nullptr && !seeds->items.empty() && root.Find("seed") == nullptr)
    PutIn(&root, "seed", ConfigTree(seeds->items.front()));
  const ConfigTree values = root;
  Interpolate(values, &root);
  root = WithFoundPaths(composed).impl_->document->root;
  ConfigTree settings = Take(&root, "settings"), sweep = Take(&root, "sweep");
  const ConfigTree names = Take(&root, "rows");
  if (sweep.kind != TreeKind::kNull) {
    if (root.Find("conditions") != nullptr) FailAt(sweep, "sweep", "there are 'conditions' already");
    PutIn(&root, "conditions", SweptConditions(sweep));
  }
  if (ConfigTree* methods = root.Find("methods")) *methods = ComposeEstimators(*methods, std::move(settings), names);
  return composed;
}

}  // namespace diffsac
