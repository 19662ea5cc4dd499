#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lab/options/config_tree.h"
#include "lab/options/options.h"

namespace diffsac {

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
