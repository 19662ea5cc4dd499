#include "lab/config/compose.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/config/paths.h"
#include "lab/options/config_tree.h"

namespace diffsac {
namespace {

using TreeKind = ConfigTree::Kind;

constexpr const char* kDefaultDataRoot = "data";

/// Throws Error: the value's place, the key, what is wrong with it.
[[noreturn]] void FailAt(const ConfigTree& tree, const std::string& key, const std::string& what) {
  const std::string place = PlaceText(tree.place);
  throw Error((place.empty() ? "" : place + ": ") + key + ": " + what);
}

/// A text, or an empty list, that says it stood where another value does.
ConfigTree ScalarAt(const ConfigTree& place_of, const std::string& text, bool quoted = true) {
  ConfigTree tree;
  tree.kind = TreeKind::kScalar;
  tree.place = place_of.place;
  tree.scalar = text;
  tree.quoted = quoted;
  return tree;
}

ConfigTree ListAt(const ConfigTree& place_of) {
  ConfigTree tree;
  tree.kind = TreeKind::kSequence;
  tree.place = place_of.place;
  return tree;
}

/// Gives a map's key this value, in place of the old one.
void PutIn(ConfigTree* map, const std::string& key, ConfigTree value) {
  map->kind = TreeKind::kMap;
  if (ConfigTree* old = map->Find(key))
    *old = std::move(value);
  else
    map->entries.push_back({key, std::move(value)});
}

/// Takes a key out of a map: what it held, an empty value when absent.
ConfigTree Take(ConfigTree* map, const std::string& key) {
  const auto entry = std::find_if(map->entries.begin(), map->entries.end(),
                                  [&](const ConfigEntry& candidate) { return candidate.key == key; });
  if (entry == map->entries.end()) return {};
  ConfigTree value = std::move(entry->value);
  map->entries.erase(entry);
  return value;
}

/// A word, or a list of words. Throws Error (FailAt) for anything else.
std::vector<std::string> Words(const ConfigTree& tree, const std::string& key) {
  if (tree.kind == TreeKind::kNull) return {};
  const std::vector<ConfigTree> items = tree.kind == TreeKind::kSequence ? tree.items : std::vector{tree};
  std::vector<std::string> words;
  for (const ConfigTree& item : items) {
    if (item.kind != TreeKind::kScalar) FailAt(tree, key, "expected a name or a list of names");
    words.push_back(item.scalar);
  }
  return words;
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

/// {outlier_ratio: 0.1} for one option, {consensus: {sigma_prior: 2}} for a path.
ConfigTree AtPath(const std::string& path, ConfigTree value) {
  std::vector<std::string> steps = SplitPath(path);
  for (; !steps.empty(); steps.pop_back()) {
    ConfigTree map;
    map.place = value.place;
    PutIn(&map, steps.back(), std::move(value));
    value = std::move(map);
  }
  return value;
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
    ConfigTree condition;
    condition.place = value.place;
    PutIn(&condition, "name", ScalarAt(value, value.scalar));
    PutIn(&condition, "value", value);
    PutIn(&condition, "data", AtPath(key, value));
    conditions.items.push_back(std::move(condition));
  }
  return conditions;
}

/// Makes rows of methods: puts them on their presets, and a swept one into a row for each of its levels.
class Methods {
 public:
  explicit Methods(ConfigTree presets) : presets_(std::move(presets)) {
    if (presets_.kind != TreeKind::kNull && presets_.kind != TreeKind::kMap)
      FailAt(presets_, "presets", "expected a map of named parts of methods");
  }

  void Add(const ConfigTree& method, ConfigTree* rows) const {
    if (method.kind != TreeKind::kMap) return rows->items.push_back(method);  // Its reader says what was expected.
    ConfigTree whole = method;
    const ConfigTree* name = whole.Find("name");
    if (name != nullptr && whole.Find("type") == nullptr && whole.Find("preset") == nullptr)
      PutIn(&whole, "preset", ConfigTree(*name));
    ConfigTree row = OnPresets(whole, "");
    if (row.Find("type") == nullptr && row.Find("sweep") == nullptr && row.Find("preset") != nullptr)
      FailAt(*row.Find("preset"), "preset", "expected a type, or a preset; " + Unknown(row.Find("preset")->scalar));
    Expand(std::move(row), rows);
  }

 private:
  static constexpr int kMostNested = 16;

  std::string Unknown(const std::string& name) const {
    std::vector<std::string> known;
    for (const ConfigEntry& entry : presets_.entries) known.push_back(entry.key);
    return "no preset is named '" + name + "'" +
           (known.empty() ? "" : "; did you mean '" + NearestWord(name, known) + "'?");
  }

  /// A name that is no preset of the file, or that of the preset itself, is one of its type's: it stays.
  ConfigTree OnPresets(ConfigTree part, const std::string& own, int depth = 0) const {
    const ConfigTree named = Take(&part, "preset");
    if (depth > kMostNested) FailAt(named, "preset", "presets that name each other in a circle");
    ConfigTree base;
    base.kind = TreeKind::kMap;
    for (const std::string& name : Words(named, "preset")) {
      const ConfigTree* preset = name == own ? nullptr : presets_.Find(name);
      if (preset == nullptr && base.Find("preset") != nullptr) FailAt(named, "preset", Unknown(name));
      if (preset == nullptr) {
        PutIn(&base, "preset", ScalarAt(named, name, false));
        continue;
      }
      if (preset->kind != TreeKind::kMap) FailAt(*preset, "presets." + name, "expected a map, part of a method");
      MergeTrees(base, OnPresets(*preset, name, depth + 1));
    }
    MergeTrees(base, std::move(part));
    return base;
  }

  static void NameLevel(ConfigTree* row, const std::string& level) {
    if (ConfigTree* name = row->Find("name")) name->scalar += "_" + level;
    ConfigTree* label = row->Find("label");
    if (label == nullptr) return;
    const std::size_t star = label->scalar.find('*');
    label->scalar.replace(std::min(star, label->scalar.size()), 1, star == std::string::npos ? " " + level : level);
  }

  /// Name, type and preset first, in whatever order they were put together: a resolved row reads back to the same.
  static ConfigTree Ordered(ConfigTree row) {
    const std::vector<std::string> first = {"name", "type", "preset"};
    const auto rank = [&](const ConfigEntry& entry) { return std::find(first.begin(), first.end(), entry.key); };
    std::stable_sort(row.entries.begin(), row.entries.end(),
                     [&](const ConfigEntry& a, const ConfigEntry& b) { return rank(a) < rank(b); });
    return row;
  }

  /// A row for each combination of the levels that `sweep` has; without it the row itself.
  void Expand(ConfigTree row, ConfigTree* rows) const {
    ConfigTree sweep = Take(&row, "sweep");
    if (sweep.entries.empty()) return rows->items.push_back(Ordered(std::move(row)));
    const auto [key, levels] = sweep.entries.front();
    sweep.entries.erase(sweep.entries.begin());
    const auto add = [&](const std::string& level, ConfigTree part) {
      ConfigTree one = row;
      NameLevel(&one, level);
      MergeTrees(one, std::move(part));
      if (!sweep.entries.empty()) PutIn(&one, "sweep", sweep);
      Expand(std::move(one), rows);
    };
    const bool plain = std::all_of(levels.items.begin(), levels.items.end(),
                                   [](const ConfigTree& value) { return value.kind == TreeKind::kScalar; });
    if (!plain || (levels.items.empty() && levels.entries.empty()))
      FailAt(levels, "sweep." + key, "expected the values of an option, [1, 2], or named parts, {a: {...}, b: {...}}");
    for (const ConfigTree& value : levels.items) add(value.scalar, AtPath(key, value));
    for (const ConfigEntry& level : levels.entries) add(level.key, OnPresets(level.value, ""));
  }

  ConfigTree presets_;
};

/// The methods of a map by name, as a list.
ConfigTree NamedMethods(ConfigTree methods) {
  if (methods.kind != TreeKind::kMap) return methods;
  ConfigTree list = ListAt(methods);
  for (ConfigEntry& entry : methods.entries) {
    if (entry.value.kind != TreeKind::kMap && entry.value.kind != TreeKind::kNull)
      FailAt(entry.value, "methods." + entry.key, "expected a map {type, ...}");
    if (entry.value.Find("name") != nullptr)
      FailAt(entry.value, "methods." + entry.key, "has its name already, without the key 'name'");
    ConfigTree method;
    method.place = entry.value.place;
    PutIn(&method, "name", ScalarAt(entry.value, entry.key));
    MergeTrees(method, std::move(entry.value));
    list.items.push_back(std::move(method));
  }
  return list;
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
  const ConfigTree presets = Take(&root, "presets"), sweep = Take(&root, "sweep");
  if (sweep.kind != TreeKind::kNull) {
    if (root.Find("conditions") != nullptr) FailAt(sweep, "sweep", "there are 'conditions' already");
    PutIn(&root, "conditions", SweptConditions(sweep));
  }
  if (ConfigTree* methods = root.Find("methods"); methods != nullptr && methods->kind != TreeKind::kScalar) {
    const ConfigTree list = NamedMethods(*methods);
    const Methods onto(presets);
    *methods = ListAt(list);
    for (const ConfigTree& method : list.items) onto.Add(method, methods);
  }
  return composed;
}

}  // namespace diffsac
