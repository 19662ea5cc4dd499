#include "lab/config/changed_keys.h"

#include <algorithm>
#include <utility>

#include "lab/config/yaml.h"
#include "lab/options/config_tree.h"

namespace diffsac {
namespace {

using Kind = ConfigTree::Kind;
using Values = std::vector<std::pair<std::string, std::string>>;

bool IsPlain(const ConfigTree& tree) { return tree.kind != Kind::kMap && tree.kind != Kind::kSequence; }

/// Every value by its path, in order.
void Flatten(const ConfigTree& tree, const std::string& path, Values* values) {
  const auto below = [&](const std::string& step) { return path.empty() ? step : path + "." + step; };
  if (IsPlain(tree)) values->emplace_back(path, FlowYaml(tree));
  for (const ConfigEntry& entry : tree.entries) Flatten(entry.value, below(entry.key), values);
  if (tree.kind != Kind::kSequence) return;
  if (std::all_of(tree.items.begin(), tree.items.end(), IsPlain)) return values->push_back({path, FlowYaml(tree)});
  for (std::size_t i = 0; i < tree.items.size(); ++i) {
    const ConfigTree* name = tree.items[i].Find("name");
    Flatten(tree.items[i], below(name != nullptr ? name->scalar : std::to_string(i)), values);
  }
}

Values ValuesOf(const std::string& yaml) {
  Values values;
  const ConfigTree tree = ParseYaml(yaml, {});
  if (tree.kind != Kind::kNull) Flatten(tree, "", &values);
  return values;
}

std::optional<std::string> ValueOf(const Values& values, const std::string& key) {
  const auto found = std::find_if(values.begin(), values.end(), [&](const auto& value) { return value.first == key; });
  return found == values.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

std::vector<ChangedKey> ChangedKeys(const std::string& before, const std::string& now) {
  const Values old_values = ValuesOf(before), new_values = ValuesOf(now);
  std::vector<ChangedKey> changed;
  for (const auto& [key, value] : old_values) {
    const auto other = ValueOf(new_values, key);
    if (other != value) changed.push_back({key, value, other});
  }
  for (const auto& [key, value] : new_values)
    if (!ValueOf(old_values, key)) changed.push_back({key, std::nullopt, value});
  return changed;
}

}  // namespace diffsac
