#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lab/options/config.h"
#include "lab/options/config_tree.h"
#include "lab/options/options.h"

namespace diffsac {

/// Reads a file. A top-level `include: other.yaml` (path relative to this file), or a list of them, is read first and
/// overridden key by key. Throws Error naming the file and line when it cannot be read or parsed.
Config ConfigFromFile(const std::string& path);
/// Parses text; `name` stands for the file in messages.
Config ConfigFromYaml(const std::string& text, const std::string& name = "<string>");
std::string ToYaml(const Config& config);

/// Applies `a.b.c=value` (value is YAML) in place of the old value, by Config::Put. Throws Error when the text has no
/// '=' or the path runs through a plain value.
void SetYaml(Config* config, const std::string& assignment);

/// The resolved options as YAML; reads back to equal options.
template <class Options>
std::string WriteYaml(Options options) {
  return ToYaml(ToConfig(std::move(options)));
}

/// Parses one document. `place` gives the file name or assignment; lines are filled in for files. Throws Error for
/// broken YAML, duplicate keys, keys that are no plain words and several documents.
ConfigTree ParseYaml(const std::string& text, const ConfigPlace& place);
/// Block style for maps, flow style for sequences of scalars.
std::string DumpYaml(const ConfigTree& tree);
/// On one line.
std::string FlowYaml(const ConfigTree& tree);

/// A key whose value two configurations differ in.
struct ChangedKey {
  std::string key;  ///< "train.batch_size"; of a list's maps "methods.ransac.seed", "parts.0.weight".
  std::optional<std::string> before, now;  ///< On one line; nothing where the key is not there.
};

/// Those of two YAML documents, in the order of `before`, then what `now` alone has. A list of plain values is one
/// value; the maps of a list are told apart by their `name`, or by their place.
std::vector<ChangedKey> ChangedKeys(const std::string& before, const std::string& now);

}  // namespace diffsac
