#pragma once

#include <memory>
#include <string>
#include <vector>

namespace diffsac {

/// A parsed YAML document that remembers where each value stood (file and line, or the --set that gave it).
/// Cheap to copy; copies share the document.
class Config {
 public:
  /// An empty document: every option keeps its default.
  Config();
  /// Reads a file. A top-level `include: other.yaml` (path relative to this file) is read first and overridden key by
  /// key. Throws Error naming the file and line when it cannot be read or parsed.
  static Config FromFile(const std::string& path);
  /// Parses text; `name` stands for the file in messages.
  static Config FromString(const std::string& text, const std::string& name = "<string>");

  /// Applies `a.b.c=value` (value is YAML) in place of the old value. Creates missing maps; a number in the path
  /// indexes a sequence. Throws Error when the text has no '=' or the path runs through a plain value.
  void Set(const std::string& assignment);

  bool Has(const std::string& dotted_path) const;
  /// The sub-document at `a.b`, empty when absent. Messages keep the whole path.
  Config Sub(const std::string& dotted_path) const;
  /// The elements of a sequence at a path, empty when absent. Throws Error when it is no sequence.
  std::vector<Config> Sequence(const std::string& dotted_path) const;
  /// The keys of this map, in order; none when it is no map.
  std::vector<std::string> Keys() const;
  /// One value as text, without quotes. Throws Error when it is absent or no plain value.
  std::string Text(const std::string& dotted_path = "") const;
  /// The document as YAML text.
  std::string Dump() const;

  /// "file.yaml:12: key.path" for messages.
  std::string Where(const std::string& dotted_path = "") const;

  // Documents of their own, which keep the places of their parts and share nothing with the documents they come from:

  /// This map under `over`: maps key by key, everything else is replaced.
  Config MergedWith(const Config& over) const;
  /// This map with one key's value replaced or added.
  Config With(const std::string& key, const Config& value) const;
  /// This map without some of its keys.
  Config Without(const std::vector<std::string>& keys) const;

  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace diffsac
