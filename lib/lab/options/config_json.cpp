#include "lab/options/config_json.h"

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
