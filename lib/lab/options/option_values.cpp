#include "lab/options/option_values.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

namespace diffsac {
namespace {

using Kind = ConfigTree::Kind;

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
