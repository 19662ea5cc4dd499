#include "lab/options/config_tree.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>
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
  for (const ConfigEntry& entry : entries)
    if (entry.key == key) return &entry.value;
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
    if (ConfigTree* old = base.Find(entry.key))
      MergeTrees(*old, std::move(entry.value));
    else
      base.entries.push_back(std::move(entry));
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
  return text.empty() || std::find(kWords.begin(), kWords.end(), text) != kWords.end();
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
  std::vector<std::string> path(dotted_path.empty() ? 0 : 1);
  for (const char c : dotted_path)
    if (c == '.')
      path.emplace_back();
    else
      path.back() += c;
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

namespace {

ConfigTree ScalarTree(std::string text, bool quoted = false) {
  ConfigTree tree;
  tree.kind = Kind::kScalar;
  tree.scalar = std::move(text);
  tree.quoted = quoted;
  return tree;
}

template <class Number>
bool ParseNumber(const ConfigTree& tree, Number& value) {
  if (tree.kind != Kind::kScalar) return false;
  std::string_view text = tree.scalar;
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number parsed{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), parsed);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return false;
  value = parsed;
  return true;
}

}  // namespace

bool ParseValue(const ConfigTree& tree, bool& value) {
  if (tree.kind != Kind::kScalar) return false;
  std::string word = tree.scalar;
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool yes = word == "true" || word == "yes" || word == "on";
  const bool no = word == "false" || word == "no" || word == "off";
  if (yes || no) value = yes;
  return yes || no;
}

bool ParseValue(const ConfigTree& tree, int& value) { return ParseNumber(tree, value); }
bool ParseValue(const ConfigTree& tree, std::int64_t& value) { return ParseNumber(tree, value); }
bool ParseValue(const ConfigTree& tree, std::uint64_t& value) { return ParseNumber(tree, value); }

bool ParseValue(const ConfigTree& tree, double& value) {
  double parsed = 0.0;
  if (!ParseNumber(tree, parsed) || !std::isfinite(parsed)) return false;
  value = parsed;
  return true;
}

bool ParseValue(const ConfigTree& tree, std::string& value) {
  if (tree.kind != Kind::kScalar) return false;
  value = tree.scalar;
  return true;
}

bool ParseValue(const ConfigTree& tree, Range& value) {
  double both = 0.0;
  if (ParseValue(tree, both)) {
    value = Range(both);
    return true;
  }
  Range parsed;
  if (tree.kind != Kind::kSequence || tree.items.size() != 2) return false;
  if (!ParseValue(tree.items[0], parsed.low) || !ParseValue(tree.items[1], parsed.high)) return false;
  value = parsed;
  return true;
}

ConfigTree ValueTree(bool value) { return ScalarTree(value ? "true" : "false"); }
ConfigTree ValueTree(int value) { return ScalarTree(std::to_string(value)); }
ConfigTree ValueTree(std::int64_t value) { return ScalarTree(std::to_string(value)); }
ConfigTree ValueTree(std::uint64_t value) { return ScalarTree(std::to_string(value)); }

ConfigTree ValueTree(double value) {
  if (std::isfinite(value)) return ScalarTree(DoubleText(value));
  return ScalarTree(std::isnan(value) ? ".nan" : value > 0.0 ? ".inf" : "-.inf");
}

ConfigTree ValueTree(const std::string& value) {
  // Words that other YAML readers would take for a number or a truth value need quotes.
  bool truth = false;
  double number = 0.0;
  const ConfigTree plain = ScalarTree(value);
  const bool taken = ParseValue(plain, truth) || ParseValue(plain, number) || HasUnfiniteNumber(plain);
  return ScalarTree(value, value.empty() || taken);
}

ConfigTree ValueTree(const Range& value) {
  if (value.low == value.high) return ValueTree(value.low);
  return ValueTree(std::vector<double>{value.low, value.high});
}

bool IsWithin(double value, const Limits& limits) {
  return (limits.exclusive_min ? value > limits.min : value >= limits.min) && value <= limits.max;
}

bool IsWithin(const Range& value, const Limits& limits) {
  return value.low <= value.high && IsWithin(value.low, limits) && IsWithin(value.high, limits);
}

std::string ExpectedText(const std::string& type, const Limits& limits) {
  const Limits none;
  const bool has_min = limits.min > none.min || limits.exclusive_min, has_max = limits.max < none.max;
  const std::string max = DoubleText(limits.max), min = DoubleText(limits.min);
  if (has_min && limits.exclusive_min) return type + " above " + min + (has_max ? " and at most " + max : "");
  if (has_min && has_max) return type + " from " + min + " to " + max;
  if (has_min) return type + " of at least " + min;
  return type + (has_max ? " of at most " + max : "");
}

std::string ExpectedText(const std::vector<std::string>& choices) {
  std::string expected = "one of ";
  for (const std::string& choice : choices) expected += (&choice == &choices.front() ? "" : ", ") + choice;
  return expected;
}

std::string GotText(const ConfigTree& value) {
  switch (value.kind) {
    case Kind::kNull:
      return "nothing";
    case Kind::kScalar:
      return "'" + value.scalar + "'";
    case Kind::kMap:
      return "a map";
    case Kind::kSequence:
      return "a list";
  }
  return "";
}

bool HasUnfiniteNumber(const ConfigTree& tree) {
  const bool unfinite = !tree.quoted && (tree.scalar == ".nan" || tree.scalar == ".inf" || tree.scalar == "-.inf");
  if (tree.kind == Kind::kScalar && unfinite) return true;
  const auto entry_has = [](const ConfigEntry& entry) { return HasUnfiniteNumber(entry.value); };
  return std::any_of(tree.items.begin(), tree.items.end(), HasUnfiniteNumber) ||
         std::any_of(tree.entries.begin(), tree.entries.end(), entry_has);
}

}  // namespace diffsac
