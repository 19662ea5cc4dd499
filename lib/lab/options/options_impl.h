#pragma once

#include <functional>
#include <string>
#include <vector>

#include "diffsac/core/former_names.h"
#include "lab/options/config_tree.h"
#include "lab/options/options.h"

namespace diffsac {

/// Reads, writes or describes one map. One object a group; groups share the document.
struct OptionsBinder::Impl {
  enum class Mode { kRead, kWrite, kDescribe };
  using Path = std::vector<std::string>;
  using Bind = std::function<void(OptionsBinder&)>;
  explicit Impl(Mode bind_mode) : mode(bind_mode) {}

  Mode mode;
  Path keys;  // Every valid key so far; the last is the one just bound.

  // Reading.
  const ConfigDocument* document = nullptr;  // For places.
  bool stored = false;                       // Unknown keys and keys that do not act are passed over.
  Path path;                                 // Of this map.
  const ConfigTree* value = nullptr;         // What stands there, null pointer when absent.
  const ConfigTree* map = nullptr;           // The same where it is a map.
  std::string unmet;                         // The message of the first unmet requirement.

  ConfigTree written;                        // Writing: this map.
  std::vector<OptionDescription> described;  // Describing: its keys.

  bool reading() const { return mode == Mode::kRead; }
  const ConfigTree* Find(const std::string& key) const {
    if (!reading() || map == nullptr) return nullptr;
    const ConfigTree* given = map->Find(key);
    return given != nullptr ? given : map->Find(FormerName(key));
  }
  /// Whether a key of the map that is read is one of `keys`, by its former name if the current one is not given.
  bool IsBound(const std::string& key) const;
  Path PathOf(const std::string& key) const {
    Path full = path;
    full.push_back(key);
    return full;
  }
  Impl Inner(const std::string& key) const {
    Impl inner(mode);
    inner.document = document;
    inner.stored = stored;
    inner.path = PathOf(key);
    return inner;
  }

  /// What is given for a key while reading; otherwise writes or describes it by `default_value`.
  const ConfigTree* Start(const char* key, const std::string& expected, const ConfigTree& default_value);
  [[noreturn]] void Fail(const Path& full, const ConfigTree& got, const std::string& expected,
                         const std::string& hint = "") const;
  void Unmet(const std::string& message) {
    if (reading() && unmet.empty()) unmet = message;
  }

  void ReadMap(const ConfigTree* tree, const Bind& bind);
  void CheckKeys() const;
  ConfigTree WriteMap(const Bind& bind);
};

}  // namespace diffsac
