#include "lab/options/config_tree.h"

#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using Kind = ConfigTree::Kind;

bool ParseIndex(const std::string& text, std::size_t& index) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), index);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

const ConfigTree* Child(const ConfigTree& tree, const std::string& step) {
  if (tree.kind == Kind::kMap) return tree.Find(step);
  std::size_t index = 0;
  if (tree.kind != Kind::kSequence || !ParseIndex(step, index) || index >= tree.items.size()) return nullptr;
  return &tree.items[index];
}

const ConfigTree* At(const ConfigTree* tree, const std::vector<std::string>& path) {
  for (std::size_t i = 0; i < path.size() && tree != nullptr; ++i) tree = Child(*tree, path[i]);
  return tree;
}

// The path that a reader of the file knows.
std::string ShownPath(const ConfigDocument& document, const std::vector<std::string>& path) {
  std::vector<std::string> whole = document.prefix;
  whole.insert(whole.end(), path.begin(), path.end());
  return JoinPath(whole);
}

}  // namespace

const ConfigTree* ConfigTree::Find(const std::string& key) const {
  for (const ConfigEntry& entry : entries) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

ConfigTree* ConfigTree::Find(const std::string& key) {
  return const_cast<ConfigTree*>(static_cast<const ConfigTree&>(*this).Find(key));
}

void MergeTrees(ConfigTree& base, ConfigTree over) {
  if (base.kind == Kind::kMap && over.kind == Kind::kNull) return;
  if (base.kind != Kind::kMap || over.kind != Kind::kMap) {
    base = std::move(over);
    return;
  }
  base.place = over.place;
  for (ConfigEntry& entry : over.entries) {
    if (ConfigTree* old = base.Find(entry.key)) {
      MergeTrees(*old, std::move(entry.value));
    } else {
      base.entries.push_back(std::move(entry));
    }
  }
}

std::string FlowText(const ConfigTree& tree) {
  std::string text;
  switch (tree.kind) {
    case Kind::kNull:
      return "~";
    case Kind::kScalar:
      return tree.quoted || tree.scalar.empty() ||
                     std::string("*&!|>%@{[").find(tree.scalar.front()) != std::string::npos
                 ? '"' + tree.scalar + '"'
                 : tree.scalar;
    case Kind::kSequence:
      for (const ConfigTree& item : tree.items) text += (text.empty() ? "" : ", ") + FlowText(item);
      return "[" + text + "]";
    case Kind::kMap:
      for (const ConfigEntry& entry : tree.entries)
        text += (text.empty() ? "" : ", ") + entry.key + ": " + FlowText(entry.value);
      return "{" + text + "}";
  }
  return text;
}

bool LooksLikeAnotherType(const std::string& text) {
  double number = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
  if (result.ec != std::errc::invalid_argument && result.ptr == text.data() + text.size()) return true;
  static constexpr std::array<const char*, 6> kWords = {"true", "false", "yes", "no", "on", "off"};
  for (const char* word : kWords) {
    if (text == word) return true;
  }
  return text.empty();
}

std::string DoubleText(double value) {
  if (!std::isfinite(value)) throw std::logic_error("an option must be a finite number");
  std::array<char, 40> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  std::string text(buffer.data(), result.ptr);
  // YAML 1.1 readers take 1e-04 for a word and 1.0e-04 for a number.
  const auto exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

std::string PlaceText(const ConfigPlace& place) {
  if (!place.assignment.empty()) return "--set " + place.assignment;
  if (place.file.empty() || place.line == 0) return place.file;
  return place.file + ":" + std::to_string(place.line);
}

std::vector<std::string> SplitPath(const std::string& dotted_path) {
  std::vector<std::string> path;
  if (dotted_path.empty()) return path;
  std::size_t begin = 0;
  for (std::size_t end = dotted_path.find('.'); end != std::string::npos; end = dotted_path.find('.', begin)) {
    path.push_back(dotted_path.substr(begin, end - begin));
    begin = end + 1;
  }
  path.push_back(dotted_path.substr(begin));
  return path;
}

std::string JoinPath(const std::vector<std::string>& path) {
  std::string joined;
  for (const std::string& step : path) joined += (joined.empty() ? "" : ".") + step;
  return joined;
}

const ConfigTree* Config::Impl::Get() const { return At(&document->root, path); }

bool GivenBySet(const ConfigDocument& document, const std::vector<std::string>& path) {
  const ConfigTree* tree = At(&document.root, path);
  return tree != nullptr && tree->place.assignment.starts_with(ShownPath(document, path) + "=");
}

std::string WhereText(const ConfigDocument& document, const std::vector<std::string>& path) {
  ConfigPlace place = document.root.place;
  // The first line of a file tells nothing; that of a part does.
  if (document.prefix.empty()) place.line = 0;
  const ConfigTree* tree = &document.root;
  for (const std::string& step : path) {
    tree = Child(*tree, step);
    if (tree == nullptr) break;
    place = tree->place;
  }
  const std::string start = PlaceText(place), shown = ShownPath(document, path);
  if (shown.empty() || GivenBySet(document, path)) return start;
  return (start.empty() ? "" : start + ": ") + shown;
}

}  // namespace diffsac
