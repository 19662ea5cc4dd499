#include "diffsac/core/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "diffsac/core/status.h"
#include "diffsac/core/yaml_tree.h"

namespace diffsac {

/// Reads a map, or writes one. One object a group; groups share the document.
struct OptionsBinder::Impl {
  bool reading = false;
  const YamlTree* root = nullptr;  // Reading: the whole document, for places.
  const YamlTree* map = nullptr;   // Reading: this group's map, null pointer when absent.
  std::vector<std::string> path;   // Reading: of this group.
  std::vector<std::string> keys;   // Reading: every valid key.
  std::string unmet;               // Reading: the message of the first unmet Require.
  YamlTree written;                // Writing: this group's map.

  const YamlTree* Start(const char* key) {
    keys.push_back(key);
    return reading && map != nullptr ? map->Find(key) : nullptr;
  }

  std::vector<std::string> PathOf(const std::string& key) const {
    std::vector<std::string> full = path;
    full.push_back(key);
    return full;
  }

  void Write(const char* key, YamlTree value) { written.entries.push_back({key, std::move(value)}); }

  [[noreturn]] void Fail(const std::vector<std::string>& full, const YamlTree& value, const std::string& expected,
                         const std::string& hint = "") const;
};

namespace {

using Kind = YamlTree::Kind;

std::string ValueText(const YamlTree& value) {
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

YamlTree ScalarTree(std::string text, bool quoted = false) {
  YamlTree tree;
  tree.kind = Kind::kScalar;
  tree.scalar = std::move(text);
  tree.quoted = quoted;
  return tree;
}

template <class Number>
bool ParseAll(std::string_view text, Number& number) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

// Each type: how a value is read (false: wrong type), written and named in messages.

bool Parse(const YamlTree& tree, bool& value) {
  if (tree.kind != Kind::kScalar) return false;
  std::string word = tree.scalar;
  std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool yes = word == "true" || word == "yes" || word == "on";
  const bool no = word == "false" || word == "no" || word == "off";
  if (yes || no) value = yes;
  return yes || no;
}

template <class Number>
bool ParseNumber(const YamlTree& tree, Number& value) {
  Number parsed{};
  if (tree.kind != Kind::kScalar || !ParseAll(tree.scalar, parsed)) return false;
  value = parsed;
  return true;
}

bool Parse(const YamlTree& tree, int& value) { return ParseNumber(tree, value); }
bool Parse(const YamlTree& tree, std::int64_t& value) { return ParseNumber(tree, value); }
bool Parse(const YamlTree& tree, std::uint64_t& value) { return ParseNumber(tree, value); }
bool Parse(const YamlTree& tree, double& value) {
  double parsed = 0.0;
  if (!ParseNumber(tree, parsed) || !std::isfinite(parsed)) return false;
  value = parsed;
  return true;
}

bool Parse(const YamlTree& tree, std::string& value) {
  if (tree.kind != Kind::kScalar) return false;
  value = tree.scalar;
  return true;
}

bool Parse(const YamlTree& tree, Range& value) {
  if (tree.kind == Kind::kScalar) {
    double both = 0.0;
    if (!Parse(tree, both)) return false;
    value = Range(both);
    return true;
  }
  Range parsed;
  if (tree.kind != Kind::kSequence || tree.items.size() != 2) return false;
  if (!Parse(tree.items[0], parsed.low) || !Parse(tree.items[1], parsed.high)) return false;
  value = parsed;
  return true;
}

YamlTree ToTree(bool value) { return ScalarTree(value ? "true" : "false"); }
YamlTree ToTree(int value) { return ScalarTree(std::to_string(value)); }
YamlTree ToTree(std::int64_t value) { return ScalarTree(std::to_string(value)); }
YamlTree ToTree(std::uint64_t value) { return ScalarTree(std::to_string(value)); }
YamlTree ToTree(double value) { return ScalarTree(DoubleText(value)); }

YamlTree ToTree(const std::string& value) {
  // Words that other YAML readers would take for a number or a truth value need quotes.
  bool truth = false;
  double number = 0.0;
  const YamlTree plain = ScalarTree(value);
  return ScalarTree(value, value.empty() || Parse(plain, truth) || Parse(plain, number));
}

template <class Item>
YamlTree ToTree(const std::vector<Item>& values) {
  YamlTree tree;
  tree.kind = Kind::kSequence;
  for (const Item& value : values) tree.items.push_back(ToTree(value));
  return tree;
}

YamlTree ToTree(const Range& value) {
  if (value.low == value.high) return ToTree(value.low);
  return ToTree(std::vector<double>{value.low, value.high});
}

/// " of at least 1", " above 0", " from 1 to 8".
std::string LimitsText(const Limits& limits) {
  const Limits none;
  const bool has_min = limits.min > none.min || limits.exclusive_min, has_max = limits.max < none.max;
  const std::string max = DoubleText(limits.max), min = DoubleText(limits.min);
  if (has_min && limits.exclusive_min) return " above " + min + (has_max ? " and at most " + max : "");
  if (has_min && has_max) return " from " + min + " to " + max;
  if (has_min) return " of at least " + min;
  return has_max ? " of at most " + max : "";
}

bool IsWithin(double value, const Limits& limits) {
  return (limits.exclusive_min ? value > limits.min : value >= limits.min) && value <= limits.max;
}
bool IsWithin(const Range& value, const Limits& limits) {
  return value.low <= value.high && IsWithin(value.low, limits) && IsWithin(value.high, limits);
}

template <class Value>
void BindValue(OptionsBinder::Impl& impl, const char* key, Value& value, const std::string& expected) {
  const YamlTree* tree = impl.Start(key);
  if (!impl.reading) impl.Write(key, ToTree(value));
  if (tree != nullptr && !Parse(*tree, value)) impl.Fail(impl.PathOf(key), *tree, expected);
}

template <class Number>
void BindLimited(OptionsBinder::Impl& impl, const char* key, Number& value, const Limits& limits,
                 const std::string& type) {
  const YamlTree* tree = impl.Start(key);
  if (!impl.reading) impl.Write(key, ToTree(value));
  if (tree == nullptr) return;
  const bool good = Parse(*tree, value) && IsWithin(value, limits);
  if (!good) impl.Fail(impl.PathOf(key), *tree, type + LimitsText(limits));
}

/// Reads a list; `check` throws for an item, given its path and tree, that is not good.
template <class Item, class Check>
void BindList(OptionsBinder::Impl& impl, const char* key, std::vector<Item>& value, const std::string& type,
              const Check& check) {
  const YamlTree* tree = impl.Start(key);
  if (!impl.reading) impl.Write(key, ToTree(value));
  if (tree == nullptr) return;
  if (tree->kind != Kind::kSequence) impl.Fail(impl.PathOf(key), *tree, type);
  value.clear();
  for (std::size_t i = 0; i < tree->items.size(); ++i) {
    std::vector<std::string> path = impl.PathOf(key);
    path.push_back(std::to_string(i));
    Item item{};
    check(path, tree->items[i], item);
    value.push_back(item);
  }
}

template <class Number>
void BindNumbers(OptionsBinder::Impl& impl, const char* key, std::vector<Number>& value, const Limits& limits,
                 const std::string& list_type, const std::string& type) {
  BindList(impl, key, value, list_type, [&](const std::vector<std::string>& path, const YamlTree& tree, Number& item) {
    const bool good = Parse(tree, item) && IsWithin(item, limits);
    if (!good) impl.Fail(path, tree, type + LimitsText(limits));
  });
}

/// Throws unless the tree is one of the choices.
void ParseChoice(const OptionsBinder::Impl& impl, const std::vector<std::string>& path, const YamlTree& tree,
                 const std::vector<std::string>& choices, std::string& value) {
  std::string parsed;
  const bool is_word = Parse(tree, parsed);
  if (is_word && std::find(choices.begin(), choices.end(), parsed) != choices.end()) {
    value = parsed;
    return;
  }
  std::string expected = "one of ";
  for (const std::string& choice : choices) expected += (&choice == &choices.front() ? "" : ", ") + choice;
  impl.Fail(path, tree, expected, is_word ? "; did you mean '" + NearestWord(parsed, choices) + "'?" : "");
}

void CheckKeys(const OptionsBinder::Impl& impl) {
  if (impl.map == nullptr) return;
  for (const YamlEntry& entry : impl.map->entries) {
    if (std::find(impl.keys.begin(), impl.keys.end(), entry.key) != impl.keys.end()) continue;
    const std::string start = PlaceText(entry.value.place);
    const std::string nearest = NearestWord(entry.key, impl.keys);
    throw Error((start.empty() ? "" : start + ": ") + "unknown key '" + JoinPath(impl.PathOf(entry.key)) + "'" +
                (nearest.empty() ? "" : "; did you mean '" + nearest + "'?"));
  }
}

/// Binds one map and checks its keys. Unmet requirements come last: a misspelt key is often their cause.
void ReadMap(OptionsBinder::Impl& impl, const YamlTree* tree, const std::function<void(OptionsBinder&)>& bind) {
  if (tree != nullptr && tree->kind != Kind::kNull && tree->kind != Kind::kMap) {
    impl.Fail(impl.path, *tree, "a map of options");
  }
  impl.reading = true;
  impl.map = tree != nullptr && tree->kind == Kind::kMap ? tree : nullptr;
  OptionsBinder binder(&impl);
  bind(binder);
  CheckKeys(impl);
  if (!impl.unmet.empty()) throw Error(impl.unmet);
}

YamlTree WriteMap(const std::function<void(OptionsBinder&)>& bind) {
  OptionsBinder::Impl impl;
  impl.written.kind = Kind::kMap;
  OptionsBinder binder(&impl);
  bind(binder);
  return std::move(impl.written);
}

}  // namespace

void OptionsBinder::Impl::Fail(const std::vector<std::string>& full, const YamlTree& value, const std::string& expected,
                               const std::string& hint) const {
  // A --set shows its key and value already.
  const bool shown = GivenBySet(*root, full);
  throw Error(WhereText(*root, full) + ": expected " + expected + (shown ? "" : ", got " + ValueText(value)) + hint);
}

void OptionsBinder::Field(const char* key, bool& value) { BindValue(*impl_, key, value, "true or false"); }
void OptionsBinder::Field(const char* key, int& value, Limits limits) {
  BindLimited(*impl_, key, value, limits, "an integer");
}
void OptionsBinder::Field(const char* key, std::int64_t& value, Limits limits) {
  BindLimited(*impl_, key, value, limits, "an integer");
}
void OptionsBinder::Field(const char* key, std::uint64_t& value) {
  BindValue(*impl_, key, value, "an integer of at least 0");
}
void OptionsBinder::Field(const char* key, double& value, Limits limits) {
  BindLimited(*impl_, key, value, limits, "a number");
}
void OptionsBinder::Field(const char* key, std::string& value) { BindValue(*impl_, key, value, "a text"); }

void OptionsBinder::Field(const char* key, Range& value, Limits limits) {
  const std::string bounds = LimitsText(limits);
  BindLimited(*impl_, key, value, limits, "a number or a range [low, high]" + std::string(bounds.empty() ? "" : ","));
}

void OptionsBinder::Field(const char* key, std::vector<double>& value, Limits limits) {
  BindNumbers(*impl_, key, value, limits, "a list of numbers", "a number");
}
void OptionsBinder::Field(const char* key, std::vector<int>& value, Limits limits) {
  BindNumbers(*impl_, key, value, limits, "a list of integers", "an integer");
}

void OptionsBinder::Field(const char* key, std::vector<std::string>& value) {
  BindList(*impl_, key, value, "a list of texts",
           [this](const std::vector<std::string>& path, const YamlTree& tree, std::string& item) {
             if (!Parse(tree, item)) impl_->Fail(path, tree, "a text");
           });
}

void OptionsBinder::Choice(const char* key, std::string& value, std::initializer_list<const char*> choices) {
  const YamlTree* tree = impl_->Start(key);
  if (!impl_->reading) impl_->Write(key, ToTree(value));
  if (tree != nullptr) ParseChoice(*impl_, impl_->PathOf(key), *tree, {choices.begin(), choices.end()}, value);
}

void OptionsBinder::Choices(const char* key, std::vector<std::string>& value,
                            std::initializer_list<const char*> choices) {
  const std::vector<std::string> words(choices.begin(), choices.end());
  BindList(*impl_, key, value, "a list",
           [&](const std::vector<std::string>& path, const YamlTree& tree, std::string& item) {
             ParseChoice(*impl_, path, tree, words, item);
           });
}

void OptionsBinder::GroupWith(const char* key, const std::function<void(OptionsBinder&)>& bind) {
  const YamlTree* tree = impl_->Start(key);
  if (!impl_->reading) return impl_->Write(key, WriteMap(bind));
  Impl inner;
  inner.root = impl_->root;
  inner.path = impl_->PathOf(key);
  ReadMap(inner, tree, bind);
}

void OptionsBinder::Ignore(const char* key) { impl_->keys.push_back(key); }

void OptionsBinder::Require(bool ok, const char* key, const std::string& expected) {
  if (ok || !impl_->reading || !impl_->unmet.empty()) return;
  impl_->unmet = WhereText(*impl_->root, impl_->PathOf(key)) + ": expected " + expected;
}

void ReadOptionsWith(const Config& config, const std::function<void(OptionsBinder&)>& bind) {
  OptionsBinder::Impl impl;
  impl.root = &config.impl_->document->root;
  impl.path = config.impl_->path;
  ReadMap(impl, config.impl_->Get(), bind);
}

std::string WriteOptionsWith(const std::function<void(OptionsBinder&)>& bind) { return DumpYaml(WriteMap(bind)); }

std::string NearestWord(const std::string& word, const std::vector<std::string>& candidates) {
  std::string nearest;
  std::size_t smallest = std::string::npos;
  for (const std::string& candidate : candidates) {
    // Levenshtein's distance, row by row.
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i + 1;
      for (std::size_t j = 0; j < candidate.size(); ++j) {
        const std::size_t replaced = diagonal + (word[i] != candidate[j]);
        diagonal = row[j + 1];
        row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
      }
    }
    if (row.back() < smallest) {
      smallest = row.back();
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace diffsac
