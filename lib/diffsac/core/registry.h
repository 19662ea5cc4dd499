#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/nearest_word.h"
#include "diffsac/core/status.h"

namespace diffsac {

/// The things of one kind that YAML or the command line names: methods, datasets, learners, image formats. Each is
/// registered at the end of its own file, so that there is no list of all of them:
/// ```
/// const Registered<DatasetEntry> kKitti("kitti", {...});   // in an anonymous namespace
/// ```
/// `Entry::kKind` says what an entry is ("dataset"). A library whose files register something says so in its
/// CMakeLists.txt (diffsac_library(... REGISTERS)), or the linker leaves out files that nobody calls by name.
template <class Entry>
class Registry {
 public:
  static Registry& Instance() {
    static Registry registry;
    return registry;
  }

  /// Throws std::logic_error for a name that is taken.
  void Add(const std::string& name, Entry entry) {
    if (!entries_.emplace(name, std::move(entry)).second)
      throw std::logic_error("two entries are named '" + name + "' as a " + Entry::kKind);
  }

  bool Has(const std::string& name) const { return entries_.count(name) > 0; }
  /// In alphabetical order.
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& [name, entry] : entries_) names.push_back(name);
    return names;
  }
  /// "a, b, c", for messages.
  std::string NamesText() const {
    std::string text;
    for (const auto& [name, entry] : entries_) text += (text.empty() ? "" : ", ") + name;
    return text;
  }
  /// Throws Error naming the nearest for an unknown name; the message starts with `where` ("f.yaml:3: data.type").
  const Entry& Find(const std::string& name, const std::string& where) const {
    const auto found = entries_.find(name);
    if (found != entries_.end()) return found->second;
    const std::string nearest = NearestWord(name, Names());
    throw Error((where.empty() ? "" : where + ": ") + "unknown " + Entry::kKind + " '" + name + "'" +
                (nearest.empty() ? "" : "; did you mean '" + nearest + "'?"));
  }

 private:
  std::map<std::string, Entry> entries_;
};

/// A constant of this type adds an entry before `main`.
template <class Entry>
struct Registered {
  Registered(const std::string& name, Entry entry) { Registry<Entry>::Instance().Add(name, std::move(entry)); }
};

}  // namespace diffsac
