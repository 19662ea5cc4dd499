#include "lab/config/tree_edits.h"

#include <algorithm>
#include <utility>

#include "diffsac/core/status.h"

namespace diffsac {

void FailAt(const ConfigTree& tree, const std::string& key, const std::string& what) {
  const std::string place = PlaceText(tree.place);
  throw Error((place.empty() ? "" : place + ": ") + key + ": " + what);
}

ConfigTree ScalarAt(const ConfigTree& place_of, const std::string& text, bool quoted) {
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

void PutIn(ConfigTree* map, const std::string& key, ConfigTree value) {
  map->kind = TreeKind::kMap;
  if (ConfigTree* old = map->Find(key))
    *old = std::move(value);
  else
    map->entries.push_back({key, std::move(value)});
}

ConfigTree Take(ConfigTree* map, const std::string& key) {
  const auto entry = std::find_if(map->entries.begin(), map->entries.end(),
                                  [&](const ConfigEntry& candidate) { return candidate.key == key; });
  if (entry == map->entries.end()) return {};
  ConfigTree value = std::move(entry->value);
  map->entries.erase(entry);
  return value;
}

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

}  // namespace diffsac
