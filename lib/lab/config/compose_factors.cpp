#include "lab/config/compose_factors.h"

#include <string>
#include <utility>
#include <vector>

#include "lab/config/tree_edits.h"

namespace diffsac {
namespace {

constexpr const char* kFactors = "factors";
constexpr const char* kBase = "factors_base";

/// Neither of these can be a setting's own name: they have a dot.
std::string SettingName(const std::string& factor, const std::string& level) {
  return std::string(kFactors) + "." + factor + "." + level;
}
const std::string kBaseSetting = std::string(kFactors) + ".base";

std::string Joined(const std::vector<std::string>& levels, const std::string& between) {
  std::string text;
  for (const std::string& level : levels) text += (text.empty() ? "" : between) + level;
  return text;
}

void CheckLevel(const ConfigTree& level, const std::string& path) {
  if (level.kind != TreeKind::kMap && level.kind != TreeKind::kNull)
    FailAt(level, path, "expected a map, part of a row");
  for (const char* own : {"name", "label"})
    if (level.Find(own) != nullptr) FailAt(*level.Find(own), path + "." + own, "the names of the levels are the row's");
  const ConfigTree* budget = level.Find("max_iterations");
  if (budget != nullptr && budget->kind == TreeKind::kSequence)
    FailAt(*budget, path + ".max_iterations", "expected one value; several are a factor of their own");
}

ConfigTree AsMap(ConfigTree tree) {
  tree.kind = TreeKind::kMap;
  return tree;
}

/// The parts of rows under their settings' names, and the levels' names in the factors' place.
void TakeLevels(ConfigTree* factors, ConfigTree* settings) {
  for (ConfigEntry& factor : factors->entries) {
    const std::string path = std::string(kFactors) + "." + factor.key;
    if (factor.value.kind != TreeKind::kMap || factor.value.entries.empty())
      FailAt(factor.value, path, "expected a map of levels {name: {...}, ...}");
    ConfigTree names = ListAt(factor.value);
    for (ConfigEntry& level : factor.value.entries) {
      CheckLevel(level.value, path + "." + level.key);
      names.items.push_back(ScalarAt(level.value, level.key));
      PutIn(settings, SettingName(factor.key, level.key), AsMap(std::move(level.value)));
    }
    factor.value = std::move(names);
  }
}

Factors LevelNames(const ConfigTree& factors) {
  Factors names;
  for (const ConfigEntry& factor : factors.entries) names.emplace_back(factor.key, Words(factor.value, factor.key));
  return names;
}

/// The row of a combination, under what `methods` says of it.
ConfigTree RowOf(const std::vector<std::string>& combination, const ConfigTree& factors, bool based, ConfigTree own) {
  ConfigTree use = ListAt(factors);
  if (based) use.items.push_back(ScalarAt(factors, kBaseSetting));
  for (std::size_t f = 0; f < combination.size(); ++f)
    use.items.push_back(ScalarAt(factors, SettingName(factors.entries[f].key, combination[f])));
  const ConfigTree used = Take(&own, "use");
  for (const std::string& name : Words(used, "use")) use.items.push_back(ScalarAt(used, name));
  ConfigTree row;
  row.place = factors.place;
  PutIn(&row, "label", ScalarAt(factors, Joined(combination, ", ")));
  MergeTrees(row, std::move(own));
  PutIn(&row, "use", std::move(use));
  return row;
}

bool AreNames(const ConfigTree& factors) {
  for (const ConfigEntry& factor : factors.entries)
    if (factor.value.kind != TreeKind::kSequence) return false;
  return true;
}

}  // namespace

std::vector<std::vector<std::string>> CombinationsOf(const Factors& factors) {
  std::vector<std::vector<std::string>> all(1);
  for (const auto& [name, levels] : factors) {
    std::vector<std::vector<std::string>> longer;
    for (const std::vector<std::string>& combination : all)
      for (const std::string& level : levels) {
        longer.push_back(combination);
        longer.back().push_back(level);
      }
    all = std::move(longer);
  }
  return all;
}

std::string FactorRowName(const std::vector<std::string>& levels) { return Joined(levels, "_"); }

void ComposeFactors(ConfigTree* experiment) {
  ConfigTree base = Take(experiment, kBase);
  ConfigTree* given = experiment->Find(kFactors);
  if (given == nullptr || given->kind == TreeKind::kNull) {
    if (base.kind != TreeKind::kNull) FailAt(base, kBase, "acts only beside 'factors'");
    return;
  }
  if (given->kind != TreeKind::kMap) FailAt(*given, kFactors, "expected a map of factors {name: {level: {...}, ...}}");
  if (AreNames(*given)) return;
  ConfigTree factors = std::move(*given), methods = Take(experiment, "methods"),
             settings = Take(experiment, "settings");
  if (methods.kind != TreeKind::kMap && methods.kind != TreeKind::kNull)
    FailAt(methods, "methods", "expected a map by name beside 'factors'");
  if (settings.kind == TreeKind::kNull) settings = AsMap(std::move(settings));
  if (settings.kind != TreeKind::kMap) FailAt(settings, "settings", "expected a map of named parts of rows");
  const bool based = base.kind != TreeKind::kNull;
  if (based) {
    CheckLevel(base, kBase);
    PutIn(&settings, kBaseSetting, std::move(base));
  }
  TakeLevels(&factors, &settings);
  ConfigTree rows;
  rows.place = methods.place;
  rows.kind = TreeKind::kMap;
  for (const std::vector<std::string>& combination : CombinationsOf(LevelNames(factors))) {
    const std::string name = FactorRowName(combination);
    if (rows.Find(name) != nullptr) FailAt(factors, kFactors, "two combinations of levels are named '" + name + "'");
    PutIn(&rows, name, RowOf(combination, factors, based, Take(&methods, name)));
  }
  for (ConfigEntry& other : methods.entries) rows.entries.push_back(std::move(other));
  PutIn(experiment, "methods", std::move(rows));
  PutIn(experiment, "settings", std::move(settings));
  PutIn(experiment, kFactors, std::move(factors));
}

}  // namespace diffsac
