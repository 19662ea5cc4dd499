#include "lab/options/config.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/estimate/learned_model.h"
#include "diffsac/guidance/engine/checkpoint_info.h"
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

namespace {

using Json = nlohmann::ordered_json;

/// No honest configuration is nested so deeply.
constexpr std::size_t kMaxDepth = 64;

/// Builds the tree as nlohmann::json reads, so that numbers keep the text they were written with.
class TreeBuilder : public nlohmann::json_sax<Json> {
 public:
  explicit TreeBuilder(const std::string& name) : name_(name) { root_.place.file = name; }
  ConfigTree TakeRoot() { return std::move(root_); }

  bool null() override { return Add(Node(Kind::kNull)); }
  bool boolean(bool value) override { return Scalar(value ? "true" : "false", false); }
  bool number_integer(std::int64_t value) override { return Scalar(std::to_string(value), false); }
  bool number_unsigned(std::uint64_t value) override { return Scalar(std::to_string(value), false); }
  bool number_float(double, const std::string& text) override { return Scalar(text, false); }
  bool string(std::string& value) override { return Scalar(value, LooksLikeAnotherType(value)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return Open(Kind::kMap); }
  bool key(std::string& value) override {
    for (const ConfigEntry& entry : open_.back()->entries)
      if (entry.key == value) throw Error(name_ + ": duplicate key '" + value + "'");
    key_ = value;
    return true;
  }
  bool end_object() override { return Close(); }
  bool start_array(std::size_t) override { return Open(Kind::kSequence); }
  bool end_array() override { return Close(); }
  bool parse_error(std::size_t, const std::string&, const Json::exception& error) override {
    throw Error(name_ + ": not valid JSON: " + error.what());
  }

 private:
  ConfigTree Node(Kind kind) const {
    ConfigTree node;
    node.kind = kind;
    node.place.file = name_;
    return node;
  }
  bool Scalar(const std::string& text, bool quoted) {
    ConfigTree node = Node(Kind::kScalar);
    node.scalar = text;
    node.quoted = quoted;
    return Add(std::move(node));
  }
  bool Add(ConfigTree node) {
    if (open_.empty()) {
      root_ = std::move(node);
    } else if (open_.back()->kind == Kind::kMap) {
      open_.back()->entries.push_back({key_, std::move(node)});
    } else {
      open_.back()->items.push_back(std::move(node));
    }
    return true;
  }
  bool Open(Kind kind) {
    if (open_.size() >= kMaxDepth) throw Error(name_ + ": nested too deeply");
    Add(Node(kind));
    ConfigTree* parent = open_.empty() ? nullptr : open_.back();
    open_.push_back(parent == nullptr            ? &root_
                    : parent->kind == Kind::kMap ? &parent->entries.back().value
                                                 : &parent->items.back());
    return true;
  }
  bool Close() {
    open_.pop_back();
    return true;
  }

  std::string name_, key_;
  ConfigTree root_;
  std::vector<ConfigTree*> open_;  ///< The containers around what comes next; only the innermost grows.
};

/// Whether JSON writes a text as it stands, not as a string.
bool IsJsonLiteral(const std::string& text) {
  const Json value = Json::parse(text, nullptr, false);
  return value.is_number() || value.is_boolean();
}

void Append(const ConfigTree& tree, std::string* text) {
  switch (tree.kind) {
    case Kind::kNull:
      *text += "null";
      return;
    case Kind::kScalar:
      *text += !tree.quoted && IsJsonLiteral(tree.scalar) ? tree.scalar : Json(tree.scalar).dump();
      return;
    case Kind::kSequence:
      *text += "[";
      for (const ConfigTree& item : tree.items) {
        if (&item != &tree.items.front()) *text += ",";
        Append(item, text);
      }
      *text += "]";
      return;
    case Kind::kMap:
      *text += "{";
      for (const ConfigEntry& entry : tree.entries) {
        if (&entry != &tree.entries.front()) *text += ",";
        *text += Json(entry.key).dump() + ":";
        Append(entry.value, text);
      }
      *text += "}";
      return;
  }
}

}  // namespace

std::string ToJson(const Config& config) {
  const ConfigTree* tree = config.impl_->Get();
  if (tree == nullptr || tree->kind == Kind::kNull) return "{}";
  std::string text;
  Append(*tree, &text);
  return text;
}

Config ConfigFromJson(const std::string& text, const std::string& name) {
  TreeBuilder builder(name);
  Json::sax_parse(text, &builder);
  ConfigTree root = builder.TakeRoot();
  if (root.kind != Kind::kMap) throw Error(name + ": expected a map of options");
  return Config(std::move(root));
}

Config CheckpointConfig(const CheckpointInfo& info, const std::string& path) {
  return ConfigFromJson(ConfigText(info, path), ConfigName(path));
}

Config ConfigOf(const TrainedConfig& trained) { return ConfigFromJson(trained.config, ConfigName(trained.checkpoint)); }

}  // namespace diffsac
