#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/options.h"

namespace diffsac {

/// Where a value was given: a line of a file, or a whole `--set a.b=c`.
struct YamlPlace {
  std::string file;        ///< Empty for values of no file.
  int line = 0;            ///< From 1; 0 when unknown.
  std::string assignment;  ///< "model.width=3" when given by --set, else empty.
};

struct YamlEntry;

/// A value of a YAML document with its place. Unlike YAML::Node it has value semantics, so documents can be merged
/// without sharing parts, and it keeps the file a value came from.
struct YamlTree {
  enum class Kind { kNull, kScalar, kMap, kSequence };
  Kind kind = Kind::kNull;
  YamlPlace place;
  std::string scalar;
  bool quoted = false;             ///< A scalar to be written in quotes.
  std::vector<YamlEntry> entries;  ///< Of a map, in order, keys distinct.
  std::vector<YamlTree> items;     ///< Of a sequence.

  /// The value of a key, null pointer when absent.
  const YamlTree* Find(const std::string& key) const;
  YamlTree* Find(const std::string& key);
};

struct YamlEntry {
  std::string key;
  YamlTree value;
};

/// Parses one document. `place` gives the file name or assignment; lines are filled in for files. Throws Error for
/// broken YAML, duplicate keys, keys that are no plain words and several documents.
YamlTree ParseYaml(const std::string& text, const YamlPlace& place);

/// Puts `over` on top of `base`: maps key by key, everything else is replaced. An empty value leaves a map as it is.
void MergeYaml(YamlTree& base, YamlTree over);

/// Block style for maps, flow style for sequences of scalars.
std::string DumpYaml(const YamlTree& tree);
/// On one line.
std::string FlowYaml(const YamlTree& tree);

/// A scalar as text that reads back to the same double; throws std::logic_error when it is not finite.
std::string DoubleText(double value);

/// The start of a message about `path`, "file.yaml:12" or "--set a.b=c"; empty when there is no place.
std::string PlaceText(const YamlPlace& place);

/// Splits "a.b.c"; empty text gives no parts.
std::vector<std::string> SplitPath(const std::string& dotted_path);
std::string JoinPath(const std::vector<std::string>& path);

struct YamlDocument {
  YamlTree root;
  std::vector<std::string> prefix;  ///< Of a part that became a document of its own: its path there, for messages.
};

/// A view: a document and a path in it.
struct Config::Impl {
  std::shared_ptr<YamlDocument> document = std::make_shared<YamlDocument>();
  std::vector<std::string> path;

  /// The value at the view's path, null pointer when absent.
  const YamlTree* Get() const;
};

/// "file.yaml:12: a.b" for messages: the place of the value, or else of the nearest map around it.
std::string WhereText(const YamlDocument& document, const std::vector<std::string>& path);

/// Whether the value at `path` is exactly what a --set gave.
bool GivenBySet(const YamlDocument& document, const std::vector<std::string>& path);

}  // namespace diffsac
