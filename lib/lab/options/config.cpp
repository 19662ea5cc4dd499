#include "lab/options/config.h"

#include <algorithm>
#include <utility>

#include "diffsac/core/status.h"
#include "lab/options/config_tree.h"

namespace diffsac {
namespace {

using Kind = ConfigTree::Kind;

/// One step of a --set path, created when it is missing in a map.
ConfigTree& Descend(ConfigTree& tree, const std::string& step, const ConfigPlace& place, const std::string& parent) {
  const std::string start = PlaceText(place) + ": ";
  if (tree.kind == Kind::kNull) {
    tree.kind = Kind::kMap;
    if (!parent.empty()) tree.place = place;
  }
  if (tree.kind == Kind::kScalar) throw Error(start + "'" + parent + "' is a value, not a map");
  if (tree.kind == Kind::kSequence) {
    const bool digits = !step.empty() && step.size() < 9 && step.find_first_not_of("0123456789") == std::string::npos;
    if (!digits || std::stoul(step) >= tree.items.size()) {
      throw Error(start + "'" + parent + "' is a list of " + std::to_string(tree.items.size()) +
                  ", expected an index below that instead of '" + step + "'");
    }
    return tree.items[std::stoul(step)];
  }
  if (ConfigTree* child = tree.Find(step)) return *child;
  ConfigTree child;
  child.place = place;
  tree.entries.push_back({step, std::move(child)});
  return tree.entries.back().value;
}

/// The same values and places in a document of its own.
Config Detached(const Config& config) {
  Config own;
  ConfigDocument& document = *own.impl_->document;
  if (const ConfigTree* tree = config.impl_->Get())
    document.root = *tree;
  else
    document.root.place = config.impl_->document->root.place;  // For messages about what is not there.
  if (document.root.kind == Kind::kNull) document.root.kind = Kind::kMap;
  document.prefix = config.impl_->document->prefix;
  document.prefix.insert(document.prefix.end(), config.impl_->path.begin(), config.impl_->path.end());
  return own;
}

}  // namespace

Config::Config() : impl_(std::make_shared<Impl>()) {}

Config::Config(ConfigTree root) : Config() { impl_->document->root = std::move(root); }

void Config::Put(const std::string& dotted_path, ConfigTree value) {
  std::vector<std::string> path = impl_->path;
  for (std::string& step : SplitPath(dotted_path)) path.push_back(std::move(step));
  // On a copy: a value that cannot be put must not leave half of its path behind.
  ConfigTree root = impl_->document->root;
  ConfigTree* tree = &root;
  std::string parent;
  for (const std::string& step : path) {
    tree = &Descend(*tree, step, value.place, parent);
    parent += (parent.empty() ? "" : ".") + step;
  }
  *tree = std::move(value);
  impl_->document->root = std::move(root);
}

bool Config::Has(const std::string& dotted_path) const {
  const ConfigTree* tree = Sub(dotted_path).impl_->Get();
  return tree != nullptr && tree->kind != Kind::kNull;
}

Config Config::Sub(const std::string& dotted_path) const {
  Config sub;
  sub.impl_->document = impl_->document;
  sub.impl_->path = impl_->path;
  for (const std::string& step : SplitPath(dotted_path)) {
    const ConfigTree* tree = sub.impl_->Get();
    if (tree != nullptr && tree->kind == Kind::kScalar) {
      throw Error(sub.Where() + ": expected a map of options");
    }
    sub.impl_->path.push_back(step);
  }
  return sub;
}

std::vector<Config> Config::Sequence(const std::string& dotted_path) const {
  std::vector<Config> items;
  const Config sequence = Sub(dotted_path);
  const ConfigTree* tree = sequence.impl_->Get();
  if (tree == nullptr || tree->kind == Kind::kNull) return items;
  if (tree->kind != Kind::kSequence) throw Error(sequence.Where() + ": expected a list");
  for (std::size_t i = 0; i < tree->items.size(); ++i) items.push_back(sequence.Sub(std::to_string(i)));
  return items;
}

std::vector<std::string> Config::Keys() const {
  std::vector<std::string> keys;
  const ConfigTree* tree = impl_->Get();
  if (tree == nullptr) return keys;
  for (const ConfigEntry& entry : tree->entries) keys.push_back(entry.key);
  return keys;
}

std::string Config::Text(const std::string& dotted_path) const {
  const Config value = Sub(dotted_path);
  const ConfigTree* tree = value.impl_->Get();
  if (tree == nullptr || tree->kind != Kind::kScalar) throw Error(value.Where() + ": expected a plain value");
  return tree->scalar;
}

std::string Config::Where(const std::string& dotted_path) const {
  std::vector<std::string> path = impl_->path;
  for (std::string& step : SplitPath(dotted_path)) path.push_back(std::move(step));
  return WhereText(*impl_->document, path);
}

Config Config::MergedWith(const Config& over) const {
  Config merged = Detached(*this);
  if (const ConfigTree* tree = over.impl_->Get()) MergeTrees(merged.impl_->document->root, *tree);
  return merged;
}

Config Config::With(const std::string& key, const Config& value) const {
  Config changed = Detached(*this);
  const ConfigTree* tree = value.impl_->Get();
  const ConfigTree put = tree == nullptr ? ConfigTree() : *tree;
  ConfigTree& root = changed.impl_->document->root;
  if (ConfigTree* old = root.Find(key))
    *old = put;
  else
    root.entries.push_back({key, put});
  return changed;
}

Config Config::Without(const std::vector<std::string>& keys) const {
  Config rest = Detached(*this);
  std::erase_if(rest.impl_->document->root.entries,
                [&](const ConfigEntry& entry) { return std::find(keys.begin(), keys.end(), entry.key) != keys.end(); });
  return rest;
}

}  // namespace diffsac
