#include "diffsac/eval/experiment.h"

#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>

#include "diffsac/core/status.h"
#include "diffsac/core/yaml_tree.h"
#include "diffsac/data/dataset_factory.h"
#include "diffsac/eval/compose.h"

namespace diffsac {
namespace {

using Kind = YamlTree::Kind;

constexpr const char* kRowKeys[] = {"name", "label", "series", "conditions", "max_problems"};

// A document of its own, with the places of its parts kept for messages.
Config ConfigOf(YamlTree tree) {
  Config config;
  if (tree.kind == Kind::kNull) tree.kind = Kind::kMap;
  config.impl_->document->root = std::move(tree);
  return config;
}

YamlTree TreeOf(const Config& config) {
  const YamlTree* tree = config.impl_->Get();
  return tree == nullptr ? YamlTree() : *tree;
}

YamlTree Text(const std::string& text) {
  YamlTree tree;
  tree.kind = Kind::kScalar;
  tree.scalar = text;
  tree.quoted = true;
  return tree;
}

YamlTree Number(double value) {
  YamlTree tree;
  tree.kind = Kind::kScalar;
  tree.scalar = DoubleText(value);
  return tree;
}

void Put(YamlTree* map, const std::string& key, YamlTree value) {
  map->kind = Kind::kMap;
  std::erase_if(map->entries, [&](const YamlEntry& entry) { return entry.key == key; });
  map->entries.push_back({key, std::move(value)});
}

template <class Item>
std::vector<std::string> Names(const std::vector<Item>& items) {
  std::vector<std::string> names;
  for (const Item& item : items) names.push_back(item.name);
  return names;
}

template <class Item>
void CheckNames(const Config& config, const std::string& list, const std::vector<Item>& items) {
  std::set<std::string> seen;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string where = config.Where(list + "." + std::to_string(i));
    if (items[i].name.empty()) throw Error(where + ": expected a name");
    if (!seen.insert(items[i].name).second) throw Error(where + ": the name '" + items[i].name + "' stands twice");
  }
}

void CheckKnown(const Config& config, const std::string& key, const std::string& what,
                const std::vector<std::string>& asked, const std::vector<std::string>& known) {
  for (const std::string& name : asked) {
    if (name.empty() || std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw Error(config.Where(key) + ": no " + what + " is named '" + name + "'; did you mean '" +
                NearestWord(name, known) + "'?");
  }
}

Condition ReadCondition(const Config& config, const YamlTree& base) {
  Condition condition;
  ReadOptionsWith(config, [&](OptionsBinder& b) {
    b.Field("name", condition.name);
    b.Field("label", condition.label);
    b.Field("value", condition.value);
    b.Ignore("data");
  });
  if (condition.label.empty()) condition.label = condition.name;
  YamlTree data = base;
  MergeYaml(data, TreeOf(config.Sub("data")));
  condition.data = ConfigOf(std::move(data));
  return condition;
}

MethodRow ReadMethodRow(const Config& config) {
  MethodRow row;
  YamlTree own = TreeOf(config), rest = own;
  if (own.kind != Kind::kMap) throw Error(config.Where() + ": expected a map {name, type, ...}");
  const auto is_row_key = [](const YamlEntry& entry) {
    return std::find(std::begin(kRowKeys), std::end(kRowKeys), entry.key) != std::end(kRowKeys);
  };
  std::erase_if(own.entries, [&](const YamlEntry& entry) { return !is_row_key(entry) && entry.key != "type"; });
  std::erase_if(rest.entries, is_row_key);
  ReadOptionsWith(ConfigOf(own), [&](OptionsBinder& b) {
    b.Field("name", row.name);
    b.Field("type", row.type);
    b.Field("label", row.label);
    b.Field("series", row.series);
    b.Field("conditions", row.conditions);
    b.Field("max_problems", row.max_problems, AtLeast(0));
  });
  if (row.type.empty()) throw Error(config.Where() + ": expected a type (ransac, diffsac, oracle, ...)");
  if (row.name.empty()) row.name = row.type;
  if (row.label.empty()) row.label = row.name;
  row.config = ConfigOf(std::move(rest));
  return row;
}

// A number (the accuracy), [accuracy, median], or `~` for what the paper leaves out.
double PaperNumber(const Config& config, const std::string& key, const YamlTree& tree) {
  if (tree.kind == Kind::kNull) return PaperValue::kUnknown;
  char* end = nullptr;
  const double value = std::strtod(tree.scalar.c_str(), &end);
  if (tree.kind != Kind::kScalar || tree.scalar.empty() || *end != '\0')
    throw Error(config.Where(key) + ": expected a number, got '" + tree.scalar + "'");
  return value;
}

// mAA, [mAA, median], or {R, t, median_R, median_t}.
PaperValue ReadPaperValue(const Config& config, const std::string& key, const YamlTree& tree) {
  PaperValue value;
  if (tree.kind == Kind::kMap) {
    const std::map<std::string, double*> slots = {{"R", &value.rotation},
                                                  {"t", &value.translation},
                                                  {"median_R", &value.median_rotation_deg},
                                                  {"median_t", &value.median_translation_deg}};
    for (const YamlEntry& entry : tree.entries) {
      const auto slot = slots.find(entry.key);
      if (slot == slots.end())
        throw Error(config.Where(key) + ": unknown key '" + entry.key + "': expected R, t, median_R or median_t");
      *slot->second = PaperNumber(config, key, entry.value);
    }
    return value;
  }
  std::vector<double*> slots = {&value.accuracy, &value.median_deg};
  const std::vector<YamlTree> items = tree.kind == Kind::kSequence ? tree.items : std::vector<YamlTree>{tree};
  if (items.empty() || items.size() > slots.size())
    throw Error(config.Where(key) + ": expected mAA, [mAA, median in degrees] or {R, t, median_R, median_t}");
  for (std::size_t i = 0; i < items.size(); ++i) *slots[i] = PaperNumber(config, key, items[i]);
  return value;
}

// Condition names may hold dots, so the tree is walked instead of paths being looked up.
std::vector<PaperRow> ReadPaper(const Config& config, const std::vector<std::string>& conditions,
                                const std::vector<std::string>& methods) {
  std::vector<PaperRow> rows;
  const YamlTree paper = TreeOf(config.Sub("paper"));
  for (const YamlEntry& method : paper.entries) {
    PaperRow row;
    row.label = method.key;
    for (const YamlEntry& entry : method.value.entries) {
      if (entry.key == "ours") {
        row.ours = entry.value.scalar;
        CheckKnown(config, "paper." + method.key, "method", {row.ours}, methods);
        continue;
      }
      CheckKnown(config, "paper." + method.key, "condition", {entry.key}, conditions);
      row.values[entry.key] = ReadPaperValue(config, "paper." + method.key, entry.value);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// In the order in which they first appear.
std::vector<BudgetSeries> SeriesOf(const std::vector<MethodRow>& methods) {
  std::vector<BudgetSeries> all;
  for (const MethodRow& row : methods) {
    if (row.series.empty()) continue;
    auto found = std::find_if(all.begin(), all.end(), [&](const BudgetSeries& one) { return one.label == row.series; });
    if (found == all.end()) found = all.insert(all.end(), {row.series, {}});
    found->methods.push_back(row.name);
  }
  return all;
}

std::vector<ImageFolder> ReadImageFolders(const Config& config) {
  std::vector<ImageFolder> folders;
  for (const Config& item : config.Sequence("figures.images")) {
    ImageFolder one;
    ReadOptionsWith(item, [&](OptionsBinder& b) {
      b.Field("scenes", one.scenes);
      b.Field("folder", one.folder);
      b.Require(!one.folder.empty(), "folder", "a folder of images");
    });
    folders.push_back(std::move(one));
  }
  return folders;
}

std::vector<std::string> TextsOf(const Config& config, const std::string& key, const YamlTree& tree) {
  const std::vector<YamlTree> items = tree.kind == Kind::kSequence ? tree.items : std::vector<YamlTree>{tree};
  std::vector<std::string> texts;
  for (const YamlTree& item : items) {
    if (item.kind != Kind::kScalar || item.scalar.empty())
      throw Error(config.Where(key) + ": expected a list of names");
    texts.push_back(item.scalar);
  }
  return texts;
}

std::vector<SceneGroup> ReadSceneGroups(const Config& config) {
  const YamlTree tree = TreeOf(config.Sub("scene_groups"));
  if (tree.kind != Kind::kMap && tree.kind != Kind::kNull)
    throw Error(config.Where("scene_groups") + ": expected a map {group: [scene, ...]}");
  std::vector<SceneGroup> groups;
  for (const YamlEntry& entry : tree.entries)
    groups.push_back({entry.key, TextsOf(config, "scene_groups." + entry.key, entry.value)});
  return groups;
}

std::vector<Comparison> ReadComparisons(const Config& config, const std::vector<std::string>& methods) {
  std::vector<Comparison> comparisons;
  for (const Config& item : config.Sequence("compare")) {
    const std::string key = "compare." + std::to_string(comparisons.size());
    const std::vector<std::string> names = TextsOf(config, key, TreeOf(item));
    if (names.size() != 2) throw Error(config.Where(key) + ": expected two methods [a, b]");
    CheckKnown(config, key, "method", names, methods);
    comparisons.push_back({names[0], names[1]});
  }
  return comparisons;
}

void CheckReferences(const Config& config, const ExperimentOptions& experiment) {
  const auto methods = Names(experiment.methods), conditions = Names(experiment.conditions);
  for (std::size_t i = 0; i < experiment.methods.size(); ++i)
    CheckKnown(config, "methods." + std::to_string(i), "condition", experiment.methods[i].conditions, conditions);
  CheckKnown(config, "reference", "method", {experiment.reference}, methods);
  const FigureOptions& figures = experiment.figures;
  CheckKnown(config, "figures.qualitative_method", "method", {figures.qualitative_method}, methods);
  CheckKnown(config, "figures.qualitative_methods", "method", figures.qualitative_methods, methods);
  CheckKnown(config, "figures.bars", "method", figures.bars, methods);
  CheckKnown(config, "figures.qualitative_conditions", "condition", figures.qualitative_conditions, conditions);
  CheckKnown(config, "figures.confidence_condition", "condition", {figures.confidence_condition}, conditions);
}

YamlTree TextList(const std::vector<std::string>& texts) {
  YamlTree list;
  list.kind = Kind::kSequence;
  for (const std::string& text : texts) list.items.push_back(Text(text));
  return list;
}

YamlTree ConditionTree(const Condition& condition) {
  YamlTree tree;
  Put(&tree, "name", Text(condition.name));
  Put(&tree, "label", Text(condition.label));
  if (!std::isnan(condition.value)) Put(&tree, "value", Number(condition.value));
  Put(&tree, "data", ParseYaml(WriteDatasetOptions(condition.data), {}));
  return tree;
}

YamlTree MethodTree(const MethodRow& row) {
  YamlTree tree;
  Put(&tree, "name", Text(row.name));
  Put(&tree, "label", Text(row.label));
  if (!row.series.empty()) Put(&tree, "series", Text(row.series));
  if (!row.conditions.empty()) Put(&tree, "conditions", TextList(row.conditions));
  if (row.max_problems > 0) Put(&tree, "max_problems", Number(row.max_problems));
  for (const YamlEntry& entry : TreeOf(row.config).entries) tree.entries.push_back(entry);
  return tree;
}

// Rotation and translation apart, or mAA and median.
YamlTree PaperValueTree(const PaperValue& value) {
  YamlTree tree;
  if (std::isnan(value.rotation) && std::isnan(value.translation)) {
    tree.kind = Kind::kSequence;
    tree.items.push_back(std::isnan(value.accuracy) ? YamlTree() : Number(value.accuracy));
    if (!std::isnan(value.median_deg)) tree.items.push_back(Number(value.median_deg));
    return tree;
  }
  tree.kind = Kind::kMap;
  for (const auto& [key, number] : {std::pair{"R", value.rotation},
                                    {"t", value.translation},
                                    {"median_R", value.median_rotation_deg},
                                    {"median_t", value.median_translation_deg}})
    if (!std::isnan(number)) Put(&tree, key, Number(number));
  return tree;
}

YamlTree PaperTree(const PaperRow& row) {
  YamlTree tree;
  tree.kind = Kind::kMap;
  if (!row.ours.empty()) Put(&tree, "ours", Text(row.ours));
  for (const auto& [condition, value] : row.values) Put(&tree, condition, PaperValueTree(value));
  return tree;
}

YamlTree ImageFoldersTree(const std::vector<ImageFolder>& folders) {
  YamlTree list;
  list.kind = Kind::kSequence;
  for (const ImageFolder& folder : folders) {
    YamlTree one;
    Put(&one, "scenes", Text(folder.scenes));
    Put(&one, "folder", Text(folder.folder));
    list.items.push_back(std::move(one));
  }
  return list;
}

YamlTree SceneGroupsTree(const std::vector<SceneGroup>& groups) {
  YamlTree tree;
  tree.kind = Kind::kMap;
  for (const SceneGroup& group : groups) Put(&tree, group.name, TextList(group.scenes));
  return tree;
}

YamlTree ComparisonsTree(const std::vector<Comparison>& comparisons) {
  YamlTree list;
  list.kind = Kind::kSequence;
  for (const Comparison& pair : comparisons) list.items.push_back(TextList({pair.a, pair.b}));
  return list;
}

}  // namespace

bool MethodRow::RunsOn(const std::string& condition) const {
  return conditions.empty() || std::find(conditions.begin(), conditions.end(), condition) != conditions.end();
}

std::string ExperimentOptions::GroupOf(const std::string& scene) const {
  for (const SceneGroup& group : scene_groups)
    for (const std::string& pattern : group.scenes)
      if (::fnmatch(pattern.c_str(), scene.c_str(), 0) == 0) return group.name;
  return scene;
}

std::size_t ExperimentOptions::RowOf(const std::string& method) const {
  const auto found = std::find_if(methods.begin(), methods.end(), [&](const auto& row) { return row.name == method; });
  return static_cast<std::size_t>(found - methods.begin());
}

void FigureOptions::Bind(OptionsBinder& b) {
  b.Field("curve", curve);
  b.Field("qualitative", qualitative, Within(0, 8));
  b.Field("qualitative_method", qualitative_method);
  b.Field("qualitative_methods", qualitative_methods);
  b.Field("qualitative_conditions", qualitative_conditions);
  b.Field("confidence_condition", confidence_condition);
  b.Field("bars", bars);
  b.Ignore("images");
}

void ExperimentOptions::Bind(OptionsBinder& b) {
  b.Field("name", name);
  b.Field("title", title);
  b.Choice("task", task, {"line", "plane", "homography", "fundamental", "essential"});
  b.Field("seed", seed);
  b.Field("problems", problems, AtLeast(1));
  b.Field("threads", threads, AtLeast(0));
  b.GroupWith("metric", [this](OptionsBinder& metric) {
    metric.Field("threshold_deg", threshold_deg, Positive());
    metric.Field("threshold_px", threshold_px, Positive());
    metric.Field("in_pixels", in_pixels);
    metric.Field("pose", pose);
    metric.Require(!pose || task == "homography", "pose", "task homography; other tasks are judged so always");
  });
  b.Field("condition_label", condition_label);
  b.Field("reference", reference);
  b.Field("notes", notes);
  b.Choice("missing", missing, {"error", "leave_out"});
  b.Field("data_root", data_root);
  b.Group("figures", figures);
  for (const char* key : {"data", "conditions", "methods", "paper", "scene_groups", "compare"}) b.Ignore(key);
}

ExperimentOptions ReadExperiment(const Config& given) {
  const Config config = ComposeExperiment(given);
  auto experiment = ReadOptions<ExperimentOptions>(config);
  if (experiment.name.empty() || experiment.name.find('/') != std::string::npos)
    throw Error(config.Where("name") + ": expected a name without '/'");
  const YamlTree base = TreeOf(config.Sub("data"));
  for (const Config& item : config.Sequence("conditions")) experiment.conditions.push_back(ReadCondition(item, base));
  if (experiment.conditions.empty()) experiment.conditions.push_back({"all", "all", std::nan(""), ConfigOf(base)});
  for (const Config& item : config.Sequence("methods")) experiment.methods.push_back(ReadMethodRow(item));
  if (experiment.methods.empty()) throw Error(config.Where("methods") + ": expected a list of methods");
  CheckNames(config, "conditions", experiment.conditions);
  CheckNames(config, "methods", experiment.methods);
  experiment.figures.budget = SeriesOf(experiment.methods);
  experiment.figures.images = ReadImageFolders(config);
  CheckReferences(config, experiment);
  experiment.paper = ReadPaper(config, Names(experiment.conditions), Names(experiment.methods));
  experiment.scene_groups = ReadSceneGroups(config);
  experiment.compare = ReadComparisons(config, Names(experiment.methods));
  return experiment;
}

std::string WriteExperiment(const ExperimentOptions& experiment) {
  YamlTree tree = ParseYaml(WriteOptions(experiment), {}), conditions, methods, paper;
  conditions.kind = methods.kind = Kind::kSequence;
  paper.kind = Kind::kMap;
  for (const Condition& condition : experiment.conditions) conditions.items.push_back(ConditionTree(condition));
  for (const MethodRow& row : experiment.methods) methods.items.push_back(MethodTree(row));
  for (const PaperRow& row : experiment.paper) Put(&paper, row.label, PaperTree(row));
  if (!experiment.figures.images.empty())
    Put(tree.Find("figures"), "images", ImageFoldersTree(experiment.figures.images));
  Put(&tree, "conditions", std::move(conditions));
  Put(&tree, "methods", std::move(methods));
  if (!paper.entries.empty()) Put(&tree, "paper", std::move(paper));
  if (!experiment.scene_groups.empty()) Put(&tree, "scene_groups", SceneGroupsTree(experiment.scene_groups));
  if (!experiment.compare.empty()) Put(&tree, "compare", ComparisonsTree(experiment.compare));
  return DumpYaml(tree);
}

std::string MetricName(const std::string& metric, const Tolerance& tolerance) {
  char text[64];
  std::snprintf(text, sizeof(text), "%s@%g%s", metric.c_str(), tolerance.value, tolerance.pixels ? "px" : "deg");
  return text;
}

}  // namespace diffsac
