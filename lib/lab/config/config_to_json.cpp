#include "lab/config/config_to_json.h"

#include <nlohmann/json.hpp>

#include "lab/options/config_tree.h"

namespace diffsac {
namespace {

using Kind = ConfigTree::Kind;
using Json = nlohmann::ordered_json;

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

}  // namespace diffsac
