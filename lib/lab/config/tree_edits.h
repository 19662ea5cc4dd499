#pragma once

#include <string>
#include <vector>

#include "lab/options/config_tree.h"

namespace diffsac {

using TreeKind = ConfigTree::Kind;

/// Throws Error: the value's place, the key, what is wrong with it.
[[noreturn]] void FailAt(const ConfigTree& tree, const std::string& key, const std::string& what);

/// A text, or an empty list, that says it stood where another value does.
ConfigTree ScalarAt(const ConfigTree& place_of, const std::string& text, bool quoted = true);
ConfigTree ListAt(const ConfigTree& place_of);

/// Gives a map's key this value, in place of the old one.
void PutIn(ConfigTree* map, const std::string& key, ConfigTree value);

/// Takes a key out of a map: what it held, an empty value when absent.
ConfigTree Take(ConfigTree* map, const std::string& key);

/// A word, or a list of words. Throws Error (FailAt) for anything else.
std::vector<std::string> Words(const ConfigTree& tree, const std::string& key);

}  // namespace diffsac
