#pragma once

#include <optional>
#include <string>
#include <vector>

namespace diffsac {

/// A key whose value two configurations differ in.
struct ChangedKey {
  std::string key;  ///< "train.batch_size"; of a list's maps "methods.ransac.seed", "parts.0.weight".
  std::optional<std::string> before, now;  ///< On one line; nothing where the key is not there.
};

/// Those of two YAML documents, in the order of `before`, then what `now` alone has. A list of plain values is one
/// value; the maps of a list are told apart by their `name`, or by their place.
std::vector<ChangedKey> ChangedKeys(const std::string& before, const std::string& now);

}  // namespace diffsac
