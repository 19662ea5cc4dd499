#include "diffsac/core/config.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "diffsac/core/yaml_tree.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Kind = YamlTree::Kind;

constexpr const char* kInclude = "include";

YamlTree LoadFile(const std::string& path, std::vector<fs::path>& open_files);

/// The document that an `include` names, relative to the file that includes it.
YamlTree LoadIncluded(const YamlTree& name, std::vector<fs::path>& open_files) {
  const std::string where = PlaceText(name.place) + ": include: ";
  if (name.kind != Kind::kScalar) throw Error(where + "expected a file name, or a list of them");
  const std::string path = (fs::path(name.place.file).parent_path() / name.scalar).string();
  const fs::path identity = fs::weakly_canonical(path);
  if (std::find(open_files.begin(), open_files.end(), identity) != open_files.end()) {
    throw Error(where + "'" + path + "' includes itself");
  }
  if (!fs::exists(path)) throw Error(where + "cannot read '" + path + "': no such file");
  // A device or pipe may never end.
  if (!fs::is_regular_file(path)) throw Error(where + "cannot read '" + path + "': not a file");
  return LoadFile(path, open_files);
}

/// Takes `include` out of a document and puts the document on top of the files it names, each on top of those before.
YamlTree ResolveInclude(YamlTree tree, std::vector<fs::path>& open_files) {
  const auto entry = std::find_if(tree.entries.begin(), tree.entries.end(),
                                  [](const YamlEntry& candidate) { return candidate.key == kInclude; });
  if (entry == tree.entries.end()) return tree;
  const YamlTree included = std::move(entry->value);
  tree.entries.erase(entry);
  const std::vector<YamlTree> names = included.kind == Kind::kSequence ? included.items : std::vector{included};
  YamlTree base;
  base.kind = Kind::kMap;
  for (const YamlTree& name : names) MergeYaml(base, LoadIncluded(name, open_files));
  MergeYaml(base, std::move(tree));
  return base;
}

YamlTree LoadText(const std::string& text, const std::string& name, std::vector<fs::path>& open_files) {
  YamlPlace place;
  place.file = name;
  YamlTree tree = ParseYaml(text, place);
  if (tree.kind != Kind::kMap && tree.kind != Kind::kNull) {
    throw Error(PlaceText(tree.place) + ": expected a map of options (key: value)");
  }
  return ResolveInclude(std::move(tree), open_files);
}

YamlTree LoadFile(const std::string& path, std::vector<fs::path>& open_files) {
  open_files.push_back(fs::weakly_canonical(path));
  YamlTree tree = LoadText(ReadFile(path), path, open_files);
  open_files.pop_back();
  return tree;
}

/// One step of a --set path, created when it is missing in a map.
YamlTree& Descend(YamlTree& tree, const std::string& step, const YamlPlace& place, const std::string& parent) {
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
  if (YamlTree* child = tree.Find(step)) return *child;
  YamlTree child;
  child.place = place;
  tree.entries.push_back({step, std::move(child)});
  return tree.entries.back().value;
}

/// The same values and places in a document of its own.
Config Detached(const Config& config) {
  Config own;
  YamlDocument& document = *own.impl_->document;
  if (const YamlTree* tree = config.impl_->Get())
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

Config Config::FromFile(const std::string& path) {
  Config config;
  std::vector<fs::path> open_files;
  config.impl_->document->root = LoadFile(path, open_files);
  return config;
}

Config Config::FromString(const std::string& text, const std::string& name) {
  Config config;
  std::vector<fs::path> open_files;
  config.impl_->document->root = LoadText(text, name, open_files);
  return config;
}

void Config::Set(const std::string& assignment) {
  const auto equals = assignment.find('=');
  const std::vector<std::string> steps = SplitPath(assignment.substr(0, equals));
  const bool empty_step = std::find(steps.begin(), steps.end(), "") != steps.end();
  if (equals == std::string::npos || steps.empty() || empty_step) {
    throw Error("--set " + assignment + ": expected key.path=value");
  }
  std::vector<std::string> path = impl_->path;
  path.insert(path.end(), steps.begin(), steps.end());
  YamlPlace place;
  // The whole path, so that messages name it even when a sub-document was set.
  place.assignment = JoinPath(path) + assignment.substr(equals);
  YamlTree value = ParseYaml(assignment.substr(equals + 1), place);

  // On a copy: a --set that fails must not leave half of its path behind.
  YamlTree root = impl_->document->root;
  YamlTree* tree = &root;
  std::string parent;
  for (const std::string& step : path) {
    tree = &Descend(*tree, step, place, parent);
    parent += (parent.empty() ? "" : ".") + step;
  }
  *tree = std::move(value);
  impl_->document->root = std::move(root);
}

bool Config::Has(const std::string& dotted_path) const {
  const YamlTree* tree = Sub(dotted_path).impl_->Get();
  return tree != nullptr && tree->kind != Kind::kNull;
}

Config Config::Sub(const std::string& dotted_path) const {
  Config sub;
  sub.impl_->document = impl_->document;
  sub.impl_->path = impl_->path;
  for (const std::string& step : SplitPath(dotted_path)) {
    const YamlTree* tree = sub.impl_->Get();
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
  const YamlTree* tree = sequence.impl_->Get();
  if (tree == nullptr || tree->kind == Kind::kNull) return items;
  if (tree->kind != Kind::kSequence) throw Error(sequence.Where() + ": expected a list");
  for (std::size_t i = 0; i < tree->items.size(); ++i) items.push_back(sequence.Sub(std::to_string(i)));
  return items;
}

std::vector<std::string> Config::Keys() const {
  std::vector<std::string> keys;
  const YamlTree* tree = impl_->Get();
  if (tree == nullptr) return keys;
  for (const YamlEntry& entry : tree->entries) keys.push_back(entry.key);
  return keys;
}

std::string Config::Text(const std::string& dotted_path) const {
  const Config value = Sub(dotted_path);
  const YamlTree* tree = value.impl_->Get();
  if (tree == nullptr || tree->kind != Kind::kScalar) throw Error(value.Where() + ": expected a plain value");
  return tree->scalar;
}

std::string Config::Dump() const {
  const YamlTree* tree = impl_->Get();
  YamlTree empty;
  empty.kind = Kind::kMap;
  return DumpYaml(tree == nullptr || tree->kind == Kind::kNull ? empty : *tree);
}

std::string Config::Where(const std::string& dotted_path) const {
  std::vector<std::string> path = impl_->path;
  for (std::string& step : SplitPath(dotted_path)) path.push_back(std::move(step));
  return WhereText(*impl_->document, path);
}

Config Config::MergedWith(const Config& over) const {
  Config merged = Detached(*this);
  if (const YamlTree* tree = over.impl_->Get()) MergeYaml(merged.impl_->document->root, *tree);
  return merged;
}

Config Config::With(const std::string& key, const Config& value) const {
  Config changed = Detached(*this);
  const YamlTree* tree = value.impl_->Get();
  const YamlTree put = tree == nullptr ? YamlTree() : *tree;
  YamlTree& root = changed.impl_->document->root;
  if (YamlTree* old = root.Find(key))
    *old = put;
  else
    root.entries.push_back({key, put});
  return changed;
}

Config Config::Without(const std::vector<std::string>& keys) const {
  Config rest = Detached(*this);
  std::erase_if(rest.impl_->document->root.entries,
                [&](const YamlEntry& entry) { return std::find(keys.begin(), keys.end(), entry.key) != keys.end(); });
  return rest;
}

}  // namespace diffsac
