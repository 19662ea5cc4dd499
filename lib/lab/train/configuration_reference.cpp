#include "lab/train/configuration_reference.h"

#include <algorithm>
#include <map>

#include "diffsac/core/status.h"
#include "lab/config/dataset_registry.h"
#include "lab/config/estimator_registry.h"
#include "lab/eval/experiment.h"
#include "lab/options/options.h"
#include "lab/train/learner.h"

namespace diffsac {
namespace {

using Descriptions = std::vector<OptionDescription>;

constexpr char kMainMethod[] = "diffsac";

std::string Code(const std::string& text) { return "`" + text + "`"; }

std::string KeyText(const std::string& key, const std::string& value) {
  return Code(value.empty() ? key : key + ": " + value);
}

/// What a key may be, where its default does not show it: "(one, sequential)", "(>= 0)", "(1 to 1e6)".
std::string LimitsText(std::string type) {
  constexpr std::pair<const char*, const char*> kShorter[] = {{"a number or a range [low, high],", ""},
                                                              {"a list of texts", ""},
                                                              {"true or false", ""},
                                                              {"an integer", ""},
                                                              {"a number", ""},
                                                              {"a text", ""},
                                                              {"anything", ""},
                                                              {"one of ", ""},
                                                              {" and at most", ", <="},
                                                              {"of at least", ">="},
                                                              {"above", ">"},
                                                              {" from ", ""},
                                                              {".0e+0", "e"}};
  if (type == "a map") return "";
  for (const auto& [text, by] : kShorter)
    for (std::size_t at; (at = type.find(text)) != std::string::npos;) type.replace(at, std::string(text).size(), by);
  type.erase(0, type.find_first_not_of(' '));
  return type.empty() ? "" : " (" + type + ")";
}

/// Writes keys as lists. A key that was written before is only named.
class Reference {
 public:
  void Text(const std::string& text) { text_ += text; }

  void Section(const std::string& heading, const std::string& help, const Descriptions& keys) {
    text_ += "\n" + heading + "\n\n" + help + "\n\n";
    place_ = heading.substr(heading.find(' ') + 1);
    Earlier earlier;
    Write("", "", keys, &earlier);
    for (const auto& [place, names] : earlier) text_ += "- As of " + place + ": " + ListOf(place, names) + ".\n";
  }

  const std::string& text() const { return text_; }

 private:
  struct Known {
    std::string place, default_value;
  };
  /// Keys that were written before, by place: as they are named, and with defaults that are others than there.
  using Earlier = std::map<std::string, std::vector<std::pair<std::string, std::string>>>;

  /// "`a`, `b: 2`", or where most of the keys of that place are there "all but `c`; `b: 2`".
  std::string ListOf(const std::string& place, const Earlier::mapped_type& names) const {
    const auto own = own_keys_.find(place);
    std::string list, missing, changed;
    std::size_t lacking = 0;
    for (const std::string& key : own == own_keys_.end() ? std::vector<std::string>() : own->second) {
      if (std::any_of(names.begin(), names.end(), [&](const auto& name) { return name.first == key; })) continue;
      missing += (lacking++ == 0 ? " but " : ", ") + key;
    }
    for (const auto& [name, text] : names) {
      list += (list.empty() ? "" : ", ") + text;
      if (text != name) changed += (changed.empty() ? "; " : ", ") + text;
    }
    const std::string shorter = "all" + missing + changed;
    return own != own_keys_.end() && lacking < own->second.size() && shorter.size() < list.size() ? shorter : list;
  }

  /// The group of a map's keys. Those of `inference` are the keys of the methods with a network.
  static std::string GroupOf(const OptionDescription& map) { return map.key == "inference" ? "" : map.key; }

  /// `group`: the key of the map that holds it.
  static std::string IdOf(const std::string& group, const OptionDescription& key) {
    return group + "." + key.key + "|" + key.help;
  }

  bool IsKnown(const std::string& group, const OptionDescription& key) const {
    const auto child_known = [&](const OptionDescription& child) { return IsKnown(GroupOf(key), child); };
    return key.children.empty() ? known_.count(IdOf(group, key)) > 0
                                : std::all_of(key.children.begin(), key.children.end(), child_known);
  }

  /// "`a: 1`" of a key, "`b` (`c: 2`)" of a map: with defaults that are others than where they were written.
  std::string Named(const std::string& path, const std::string& group, const OptionDescription& key) const {
    if (key.children.empty()) {
      const bool same = known_.at(IdOf(group, key)).default_value == key.default_value;
      return KeyText(path + key.key, same ? "" : key.default_value.empty() ? "~" : key.default_value);
    }
    return Code(path + key.key) + (Changed("", key).empty() ? "" : " (" + Changed("", key).substr(2) + ")");
  }

  std::string Changed(const std::string& path, const OptionDescription& map) const {
    std::string text;
    for (const OptionDescription& key : map.children) {
      const std::string named = Named(path, GroupOf(map), key);
      text += !key.children.empty()           ? Changed(path + key.key + ".", key)
              : named != Code(path + key.key) ? ", " + named
                                              : "";
    }
    return text;
  }

  std::string PlaceOf(const std::string& group, const OptionDescription& key) const {
    return key.children.empty() ? known_.at(IdOf(group, key)).place : PlaceOf(GroupOf(key), key.children.front());
  }

  /// `path`: of the map, with a dot behind.
  void Write(const std::string& path, const std::string& group, const Descriptions& keys, Earlier* earlier) {
    for (const OptionDescription& key : keys) {
      const std::string full = path + key.key;
      if (IsKnown(group, key)) {
        (*earlier)[PlaceOf(group, key)].emplace_back(Code(full), Named(path, group, key));
        continue;
      }
      text_ += std::string(2 * static_cast<std::size_t>(std::count(path.begin(), path.end(), '.')), ' ') + "- " +
               KeyText(key.key, key.default_value) + LimitsText(key.type);
      if (!key.help.empty()) text_ += ": " + key.help;
      if (!key.when.empty()) text_ += "; with " + key.when;
      text_ += "\n";
      if (path.empty()) own_keys_[place_].push_back(Code(key.key));
      if (key.children.empty()) known_[IdOf(group, key)] = {place_, key.default_value};
      Write(full + ".", GroupOf(key), key.children, earlier);
    }
  }

  std::string text_, place_;
  std::map<std::string, Known> known_;
  std::map<std::string, std::vector<std::string>> own_keys_;  ///< Of a place, those that were written there.
};

void AddTraining(Reference* reference) {
  const Task first = TaskFromString(TaskNames().front());
  const auto& learners = Registry<LearnerEntry>::Instance();
  reference->Section("## Trainings", "`diffsac_train`; here of `method: diffsac`.",
                     DescribeOptions(TrainConfig(kMainMethod, first)));
  for (const std::string& name : learners.Names())
    if (name != kMainMethod)
      reference->Section("### `method: " + name + "`", learners.Find(name, "").help,
                         DescribeOptions(TrainConfig(name, first)));
}

void AddData(Reference* reference) {
  reference->Text("\n## Data\n\nThe map `data` of both programs (docs/generators.md, data_tools/README.md).\n");
  const auto& datasets = Registry<DatasetEntry>::Instance();
  for (const std::string& name : datasets.Names()) {
    const DatasetEntry& entry = datasets.Find(name, "");
    reference->Section("### `type: " + name + "`", entry.help, entry.describe());
  }
  reference->Section("### `type: mixture`", "Training alone: examples of several datasets, drawn by weight.",
                     DescribeMixture());
}

/// The keys for the first task that a type has.
Descriptions FirstKeys(const EstimatorEntry& entry) {
  for (const std::string& task : TaskNames()) {
    try {
      return entry.describe(TaskFromString(task));
    } catch (const Error&) {
    }
  }
  return {};
}

void AddTables(Reference* reference) {
  reference->Section("## Tables", "`diffsac_eval`.", DescribeOptions<ExperimentOptions>());
  reference->Text(
      "\n## Methods\n\nA method with a network has a `checkpoint`, whose group `inference` has the defaults of its "
      "other keys.\n");
  const auto& methods = Registry<EstimatorEntry>::Instance();
  std::vector<std::string> names = methods.Names();
  // What others are told by comes first.
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return name == "ransac"; });
  for (const std::string& name : names) {
    const EstimatorEntry& entry = methods.Find(name, "");
    reference->Section("### `type: " + name + "`", entry.help, FirstKeys(entry));
  }
}

}  // namespace

std::string ConfigurationReference() {
  Reference reference;
  AddTables(&reference);
  AddData(&reference);
  AddTraining(&reference);
  return reference.text();
}

}  // namespace diffsac
