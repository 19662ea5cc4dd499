#pragma once

#include <memory>
#include <string>
#include <vector>

namespace diffsac {

struct ConfigTree;

/// A document of options that remembers where each value stood (file and line, or the --set that gave it).
/// lab/config/yaml.h reads and writes it as YAML. Cheap to copy; copies share the document.
class Config {
 public:
  /// An empty document: every option keeps its default.
  Config();
  explicit Config(ConfigTree root);

  /// Puts a value at a path in place of the old one. Creates missing maps; a number in the path indexes a sequence.
  /// Throws Error when the path runs through a plain value.
  void Put(const std::string& dotted_path, ConfigTree value);

  bool Has(const std::string& dotted_path) const;
  /// The sub-document at `a.b`, empty when absent. Messages keep the whole path.
  Config Sub(const std::string& dotted_path) const;
  /// The elements of a sequence at a path, empty when absent. Throws Error when it is no sequence.
  std::vector<Config> Sequence(const std::string& dotted_path) const;
  /// The keys of this map, in order; none when it is no map.
  std::vector<std::string> Keys() const;
  /// One value as text, without quotes. Throws Error when it is absent or no plain value.
  std::string Text(const std::string& dotted_path = "") const;

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

struct CheckpointInfo;
struct TrainedConfig;

/// A configuration as checkpoints hold it, a JSON object whose numbers keep their digits.
std::string ToJson(const Config& config);

/// Parses a JSON object; `name` stands for the file in messages. Throws Error for anything else, and for duplicate
/// keys.
Config ConfigFromJson(const std::string& text, const std::string& name);

/// The training configuration of a checkpoint. Throws Error, naming the file, when it cannot be read.
Config CheckpointConfig(const CheckpointInfo& info, const std::string& path);
Config ConfigOf(const TrainedConfig& trained);

}  // namespace diffsac
