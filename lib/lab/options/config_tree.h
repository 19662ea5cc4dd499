#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lab/options/options.h"

namespace diffsac {

/// Where a value was given: a line of a file, or a whole `--set a.b=c`.
struct ConfigPlace {
  std::string file;        ///< Empty for values of no file.
  int line = 0;            ///< From 1; 0 when unknown.
  std::string assignment;  ///< "model.width=3" when given by --set, else empty.
};

struct ConfigEntry;

/// A value of a configuration with its place. It has value semantics, so documents can be merged without sharing parts.
struct ConfigTree {
  enum class Kind { kNull, kScalar, kMap, kSequence };
  Kind kind = Kind::kNull;
  ConfigPlace place;
  std::string scalar;
  bool quoted = false;               ///< A scalar to be written in quotes.
  std::vector<ConfigEntry> entries;  ///< Of a map, in order, keys distinct.
  std::vector<ConfigTree> items;     ///< Of a sequence.

  /// The value of a key, null pointer when absent.
  const ConfigTree* Find(const std::string& key) const;
  ConfigTree* Find(const std::string& key);
};

struct ConfigEntry {
  std::string key;
  ConfigTree value;
};

/// Puts `over` on top of `base`: maps key by key, everything else is replaced. An empty value leaves a map as it is.
void MergeTrees(ConfigTree& base, ConfigTree over);

/// On one line, for documentation and messages: {a: 1, b: [x, y]}.
std::string FlowText(const ConfigTree& tree);

/// Whether a text without quotes would be read as a number, as true or false, or as nothing.
bool LooksLikeAnotherType(const std::string& text);

/// A scalar as text that reads back to the same double; throws std::logic_error when it is not finite.
std::string DoubleText(double value);

/// The start of a message about `path`, "file.yaml:12" or "--set a.b=c"; empty when there is no place.
std::string PlaceText(const ConfigPlace& place);

/// Splits "a.b.c"; empty text gives no parts.
std::vector<std::string> SplitPath(const std::string& dotted_path);
std::string JoinPath(const std::vector<std::string>& path);

struct ConfigDocument {
  ConfigTree root;
  std::vector<std::string> prefix;  ///< Of a part that became a document of its own: its path there, for messages.
};

/// A view: a document and a path in it.
struct Config::Impl {
  std::shared_ptr<ConfigDocument> document = std::make_shared<ConfigDocument>();
  std::vector<std::string> path;

  /// The value at the view's path, null pointer when absent.
  const ConfigTree* Get() const;
};

/// "file.yaml:12: a.b" for messages: the place of the value, or else of the nearest map around it.
std::string WhereText(const ConfigDocument& document, const std::vector<std::string>& path);

/// Whether the value at `path` is exactly what a --set gave.
bool GivenBySet(const ConfigDocument& document, const std::vector<std::string>& path);

/// How each type of value is read (false: wrong type, the value is left as it was) ...
bool ParseValue(const ConfigTree& tree, bool& value);
bool ParseValue(const ConfigTree& tree, int& value);
bool ParseValue(const ConfigTree& tree, std::int64_t& value);
bool ParseValue(const ConfigTree& tree, std::uint64_t& value);
bool ParseValue(const ConfigTree& tree, double& value);
bool ParseValue(const ConfigTree& tree, std::string& value);
bool ParseValue(const ConfigTree& tree, Range& value);

/// ... and written. A number that is not finite becomes a scalar that nothing reads.
ConfigTree ValueTree(bool value);
ConfigTree ValueTree(int value);
ConfigTree ValueTree(std::int64_t value);
ConfigTree ValueTree(std::uint64_t value);
ConfigTree ValueTree(double value);
ConfigTree ValueTree(const std::string& value);
ConfigTree ValueTree(const Range& value);
template <class Item>
ConfigTree ValueTree(const std::vector<Item>& values) {
  ConfigTree tree;
  tree.kind = ConfigTree::Kind::kSequence;
  for (const Item& value : values) tree.items.push_back(ValueTree(value));
  return tree;
}

bool IsWithin(double value, const Limits& limits);
bool IsWithin(const Range& value, const Limits& limits);

/// What messages expect: "an integer of at least 1", "a number above 0".
std::string ExpectedText(const std::string& type, const Limits& limits);
/// "one of a, b, c".
std::string ExpectedText(const std::vector<std::string>& choices);
/// What messages got: "'abc'", "a list", "nothing".
std::string GotText(const ConfigTree& value);

/// Whether the tree, or a part of it, is a number that is not finite.
bool HasUnfiniteNumber(const ConfigTree& tree);

}  // namespace diffsac
