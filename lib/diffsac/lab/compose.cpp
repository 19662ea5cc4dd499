#include "diffsac/lab/compose.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>
#include <vector>

#include "diffsac/core/resources.h"
#include "diffsac/core/status.h"
#include "diffsac/core/yaml_tree.h"

namespace diffsac {
namespace {

using TreeKind = YamlTree::Kind;

constexpr const char* kDefaultDataRoot = "data";

[[noreturn]] void FailAt(const YamlTree& tree, const std::string& key, const std::string& what) {
  const std::string place = PlaceText(tree.place);
  throw Error((place.empty() ? "" : place + ": ") + key + ": " + what);
}

YamlTree ScalarAt(const YamlTree& place_of, const std::string& text, bool quoted = true) {
  YamlTree tree;
  tree.kind = TreeKind::kScalar;
  tree.place = place_of.place;
  tree.scalar = text;
  tree.quoted = quoted;
  return tree;
}

YamlTree ListAt(const YamlTree& place_of) {
  YamlTree tree;
  tree.kind = TreeKind::kSequence;
  tree.place = place_of.place;
  return tree;
}

void PutIn(YamlTree* map, const std::string& key, YamlTree value) {
  map->kind = TreeKind::kMap;
  if (YamlTree* old = map->Find(key))
    *old = std::move(value);
  else
    map->entries.push_back({key, std::move(value)});
}

/// Takes a key out of a map: what it held, an empty value when absent.
YamlTree Take(YamlTree* map, const std::string& key) {
  const auto entry = std::find_if(map->entries.begin(), map->entries.end(),
                                  [&](const YamlEntry& candidate) { return candidate.key == key; });
  if (entry == map->entries.end()) return {};
  YamlTree value = std::move(entry->value);
  map->entries.erase(entry);
  return value;
}

/// A word, or a list of words.
std::vector<std::string> Words(const YamlTree& tree, const std::string& key) {
  if (tree.kind == TreeKind::kNull) return {};
  const std::vector<YamlTree> items = tree.kind == TreeKind::kSequence ? tree.items : std::vector{tree};
  std::vector<std::string> words;
  for (const YamlTree& item : items) {
    if (item.kind != TreeKind::kScalar) FailAt(tree, key, "expected a name or a list of names");
    words.push_back(item.scalar);
  }
  return words;
}

std::string TextOf(const YamlTree& map, const std::string& key) {
  const YamlTree* value = map.Find(key);
  return value == nullptr ? "" : value->scalar;
}

/// Puts values of the experiment in the place of ${key.path}.
void Interpolate(const YamlTree& experiment, YamlTree* tree) {
  for (std::size_t at = 0; (at = tree->scalar.find("${", at)) != std::string::npos;) {
    const std::size_t end = tree->scalar.find('}', at);
    if (end == std::string::npos) FailAt(*tree, tree->scalar, "'${' without '}'");
    const std::string path = tree->scalar.substr(at + 2, end - at - 2);
    const YamlTree* value = &experiment;
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
  for (YamlTree& item : tree->items) Interpolate(experiment, &item);
  for (YamlEntry& entry : tree->entries) Interpolate(experiment, &entry.value);
}

bool IsAvailable(const YamlTree& alternative) {
  const YamlTree* needs = alternative.Find("needs");
  if (needs == nullptr) return true;
  const std::vector<std::string> places = Words(*needs, "needs");
  return std::any_of(places.begin(), places.end(),
                     [](const std::string& place) { return std::filesystem::exists(place); });
}

YamlTree OnAlternative(YamlTree experiment) {
  const YamlTree alternatives = Take(&experiment, "alternatives");
  const YamlTree* data = experiment.Find("data");
  if (alternatives.kind == TreeKind::kNull || (data != nullptr && data->Find("paths") != nullptr)) return experiment;
  if (alternatives.kind != TreeKind::kSequence) FailAt(alternatives, "alternatives", "expected a list of maps");
  for (const YamlTree& one : alternatives.items)
    if (one.kind != TreeKind::kMap) FailAt(one, "alternatives", "expected a list of maps");
  auto chosen = std::find_if(alternatives.items.begin(), alternatives.items.end(), IsAvailable);
  if (chosen == alternatives.items.end()) chosen = alternatives.items.begin();
  if (chosen == alternatives.items.end()) return experiment;
  YamlTree base = *chosen;
  Take(&base, "needs");
  MergeYaml(base, std::move(experiment));
  return base;
}

/// A condition for each value of one option of the data.
YamlTree SweptConditions(const YamlTree& sweep) {
  if (sweep.kind != TreeKind::kMap || sweep.entries.size() != 1 || sweep.entries[0].value.kind != TreeKind::kSequence)
    FailAt(sweep, "sweep", "expected an option of the data and its values, {outlier_ratio: [0.1, 0.2]}");
  const auto& [key, values] = sweep.entries[0];
  YamlTree conditions = ListAt(sweep);
  for (const YamlTree& value : values.items) {
    if (value.kind != TreeKind::kScalar) FailAt(value, "sweep", "expected plain values");
    YamlTree condition, data;
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
  explicit Settings(YamlTree settings) : settings_(std::move(settings)) {
    if (settings_.kind != TreeKind::kNull && settings_.kind != TreeKind::kMap)
      FailAt(settings_, "settings", "expected a map of named parts of rows");
  }

  YamlTree Resolve(YamlTree part, int depth = 0) const {
    const YamlTree use = Take(&part, "use");
    if (use.kind == TreeKind::kNull) return part;
    if (depth > kMostNested) FailAt(use, "use", "settings that use each other in a circle");
    YamlTree base;
    base.kind = TreeKind::kMap;
    for (const std::string& name : Words(use, "use")) {
      const YamlTree* setting = settings_.Find(name);
      if (setting == nullptr) FailAt(use, "use", "no setting is named '" + name + "'" + Nearest(name));
      if (setting->kind != TreeKind::kMap) FailAt(*setting, "settings." + name, "expected a map, part of a row");
      MergeYaml(base, Resolve(*setting, depth + 1));
    }
    MergeYaml(base, std::move(part));
    return base;
  }

 private:
  static constexpr int kMostNested = 16;

  std::string Nearest(const std::string& name) const {
    std::vector<std::string> known;
    for (const YamlEntry& entry : settings_.entries) known.push_back(entry.key);
    return known.empty() ? "" : "; did you mean '" + NearestWord(name, known) + "'?";
  }

  YamlTree settings_;
};

/// A row each for a list of budgets.
void AddRows(const YamlTree& row, YamlTree* rows) {
  const YamlTree* budgets = row.Find("max_iterations");
  if (budgets == nullptr || budgets->kind != TreeKind::kSequence) {
    rows->items.push_back(row);
    return;
  }
  const std::string name = TextOf(row, "name"), label = TextOf(row, "label"), series = TextOf(row, "series");
  const std::string shown = label.empty() ? name : label;
  for (const YamlTree& budget : budgets->items) {
    if (budget.kind != TreeKind::kScalar) FailAt(budget, "max_iterations", "expected numbers");
    YamlTree one = row;
    PutIn(&one, "name", ScalarAt(row, name + "_" + budget.scalar));
    PutIn(&one, "label", ScalarAt(row, shown + " " + budget.scalar));
    PutIn(&one, "series", ScalarAt(row, series.empty() ? shown : series));
    PutIn(&one, "max_iterations", budget);
    rows->items.push_back(std::move(one));
  }
}

/// The rows of a map by name, as a list.
YamlTree NamedRows(YamlTree methods) {
  if (methods.kind != TreeKind::kMap) return methods;
  YamlTree rows = ListAt(methods);
  for (YamlEntry& entry : methods.entries) {
    if (entry.value.kind != TreeKind::kMap) FailAt(entry.value, "methods." + entry.key, "expected a map {type, ...}");
    if (entry.value.Find("name") != nullptr)
      FailAt(entry.value, "methods." + entry.key, "has its name already, without the key 'name'");
    YamlTree row;
    row.place = entry.value.place;
    PutIn(&row, "name", ScalarAt(entry.value, entry.key));
    MergeYaml(row, std::move(entry.value));
    rows.items.push_back(std::move(row));
  }
  return rows;
}

/// The oracle, which is a ceiling and no competitor, last.
YamlTree WithOracleLast(YamlTree rows) {
  std::stable_partition(rows.items.begin(), rows.items.end(),
                        [](const YamlTree& row) { return TextOf(row, "type") != "oracle"; });
  return rows;
}

/// The named rows in that order.
YamlTree Chosen(const YamlTree& rows, const YamlTree& names) {
  std::vector<std::string> known;
  for (const YamlTree& row : rows.items) known.push_back(TextOf(row, "name"));
  YamlTree chosen = ListAt(rows);
  for (const std::string& name : Words(names, "rows")) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      FailAt(names, "rows", "no method is named '" + name + "'; did you mean '" + NearestWord(name, known) + "'?");
    chosen.items.push_back(rows.items[static_cast<std::size_t>(found - known.begin())]);
  }
  return chosen;
}

YamlTree Budgeted(const YamlTree& listed) {
  YamlTree rows = ListAt(listed);
  for (const YamlTree& row : listed.items) AddRows(row, &rows);
  return rows;
}

/// What `rows` did not choose goes to *gone, by name.
YamlTree ComposeEstimators(const YamlTree& methods, YamlTree settings, const YamlTree& names,
                        std::set<std::string>* gone) {
  const YamlTree listed = NamedRows(methods);
  if (listed.kind != TreeKind::kSequence) return listed;  // Its reader says what was expected.
  const Settings known(std::move(settings));
  YamlTree resolved = ListAt(listed);
  for (const YamlTree& row : listed.items)
    resolved.items.push_back(row.kind == TreeKind::kMap ? known.Resolve(row) : row);
  // A list has its author's order; a map may come from several files.
  if (methods.kind == TreeKind::kMap) resolved = WithOracleLast(std::move(resolved));
  if (names.kind == TreeKind::kNull) return Budgeted(resolved);
  for (const YamlTree& row : Budgeted(resolved).items) gone->insert(TextOf(row, "name"));
  YamlTree rows = Budgeted(Chosen(resolved, names));
  for (const YamlTree& row : rows.items) gone->erase(TextOf(row, "name"));
  return rows;
}

/// Of a list of names, or of pairs of names, what has none of these.
void DropFrom(YamlTree* list, const std::set<std::string>& gone) {
  if (list == nullptr) return;
  std::erase_if(list->items, [&](const YamlTree& item) {
    return gone.count(item.scalar) > 0 || std::any_of(item.items.begin(), item.items.end(), [&](const YamlTree& name) {
             return gone.count(name.scalar) > 0;
           });
  });
}

void DropKey(const std::string& key, YamlTree* map, const std::set<std::string>& gone) {
  if (map != nullptr && gone.count(TextOf(*map, key)) > 0) Take(map, key);
}

/// Takes out what refers to rows that were not chosen.
void ForgetRows(const std::set<std::string>& gone, YamlTree* root) {
  if (YamlTree* figures = root->Find("figures")) {
    DropFrom(figures->Find("bars"), gone);
    DropFrom(figures->Find("qualitative_methods"), gone);
    DropKey("qualitative_method", figures, gone);
  }
  DropKey("reference", root, gone);
  DropFrom(root->Find("compare"), gone);
  if (YamlTree* paper = root->Find("paper"))
    for (YamlEntry& row : paper->entries) DropKey("ours", &row.value, gone);
}

/// A single value as a list of one.
YamlTree ListOf(YamlTree value) {
  if (value.kind != TreeKind::kScalar) return value;
  YamlTree list = ListAt(value);
  list.items.push_back(std::move(value));
  return list;
}

YamlTree PairsOf(const YamlTree& compare) {
  if (compare.kind != TreeKind::kMap) return compare;
  YamlTree pairs = ListAt(compare);
  for (const YamlEntry& entry : compare.entries)
    for (const std::string& other : Words(entry.value, "compare." + entry.key)) {
      YamlTree pair = ListAt(entry.value);
      pair.items = {ScalarAt(entry.value, entry.key), ScalarAt(entry.value, other)};
      pairs.items.push_back(std::move(pair));
    }
  return pairs;
}

}  // namespace

Config ComposeExperiment(const Config& config) {
  const YamlTree* given = config.impl_->Get();
  Config composed;
  YamlTree& root = composed.impl_->document->root;
  if (given != nullptr) root = *given;
  if (root.kind == TreeKind::kNull) root.kind = TreeKind::kMap;
  if (root.kind != TreeKind::kMap) return composed;
  if (root.Find("data_root") == nullptr) PutIn(&root, "data_root", ScalarAt(root, kDefaultDataRoot));
  const YamlTree values = root;
  Interpolate(values, &root);
  root = WithFoundPaths(composed).impl_->document->root;
  root = OnAlternative(std::move(root));
  YamlTree settings = Take(&root, "settings"), sweep = Take(&root, "sweep");
  const YamlTree names = Take(&root, "rows");
  if (sweep.kind != TreeKind::kNull) {
    if (root.Find("conditions") != nullptr) FailAt(sweep, "sweep", "there are 'conditions' already");
    PutIn(&root, "conditions", SweptConditions(sweep));
  }
  std::set<std::string> gone;
  if (YamlTree* methods = root.Find("methods")) *methods = ComposeEstimators(*methods, std::move(settings), names, &gone);
  if (YamlTree* compare = root.Find("compare")) *compare = PairsOf(*compare);
  ForgetRows(gone, &root);
  if (YamlTree* groups = root.Find("scene_groups"))
    for (YamlEntry& group : groups->entries) group.value = ListOf(std::move(group.value));
  return composed;
}

}  // namespace diffsac
