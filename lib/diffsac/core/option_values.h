#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/core/yaml_tree.h"

namespace diffsac {

/// How each type of value is read (false: wrong type, the value is left as it was) ...
bool ParseValue(const YamlTree& tree, bool& value);
bool ParseValue(const YamlTree& tree, int& value);
bool ParseValue(const YamlTree& tree, std::int64_t& value);
bool ParseValue(const YamlTree& tree, std::uint64_t& value);
bool ParseValue(const YamlTree& tree, double& value);
bool ParseValue(const YamlTree& tree, std::string& value);
bool ParseValue(const YamlTree& tree, Range& value);

/// ... and written. A number that is not finite becomes a scalar that nothing reads.
YamlTree ValueTree(bool value);
YamlTree ValueTree(int value);
YamlTree ValueTree(std::int64_t value);
YamlTree ValueTree(std::uint64_t value);
YamlTree ValueTree(double value);
YamlTree ValueTree(const std::string& value);
YamlTree ValueTree(const Range& value);
template <class Item>
YamlTree ValueTree(const std::vector<Item>& values) {
  YamlTree tree;
  tree.kind = YamlTree::Kind::kSequence;
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
std::string GotText(const YamlTree& value);

/// Whether the tree, or a part of it, is a number that is not finite.
bool HasUnfiniteNumber(const YamlTree& tree);

}  // namespace diffsac
