#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/registry.h"
#include "lab/config/make_estimator.h"
#include "lab/options/options.h"

namespace diffsac {

/// Calls `defaults`, whose Error says of a task that the row does not estimate it; with the place of the row's type.
template <class Defaults>
auto DefaultsAt(const Config& row, const Defaults& defaults) {
  try {
    return defaults();
  } catch (const Error& error) {
    throw Error(row.Where("type") + ": " + error.what());
  }
}

/// What a row's key `preset` says; the first of those that its type has where it says nothing. The reader of the row
/// refuses other names.
inline std::string PresetOf(const Config& row, const std::vector<std::string>& presets) {
  if (presets.empty()) return "";
  const std::string named = row.Has("preset") ? row.Text("preset") : presets.front();
  return std::find(presets.begin(), presets.end(), named) != presets.end() ? named : presets.front();
}

/// A type of row. It is registered at the end of the file that estimates; see RegisteredEstimator, and
/// lab/config/registered_learned_estimator.h for rows with a network.
struct EstimatorEntry {
  static constexpr const char* kKind = "method type";
  std::string help;  ///< One line for the documentation.
  /// All throw Error for a task that it does not estimate; the first two for wrong options, with file, line and key.
  std::function<TableRow(const Config&, Task, const EstimatorContext&)> make;
  std::function<Config(const Config&, Task, const EstimatorContext&)> resolve;  ///< Every key.
  std::function<std::vector<OptionDescription>(Task)> describe;
};

/// A row that does not learn:
/// ```
/// const RegisteredEstimator<TheilSenOptions> kTheilSen(
///     "theil_sen", "The median of ...", [](Task task) { ...; return TheilSenOptions(); },
///     [](const TheilSenOptions& options) { return std::make_unique<TheilSenEstimator>(options); });
/// ```
/// defaults: of a task; throws Error for one that it does not estimate. make: called with what was read. presets: what
/// the key `preset` may be, "default" first, where there are other sets of defaults: of_preset.
template <class Options>
struct RegisteredEstimator : Registered<EstimatorEntry> {
  using Defaults = std::function<Options(Task)>;
  using PresetDefaults = std::function<Options(Task, const std::string& preset)>;
  using Make = std::function<TableRow(const Options&)>;
  RegisteredEstimator(const std::string& type, const std::string& help, Defaults defaults, Make make)
      : RegisteredEstimator(
            type, help, {}, [defaults = std::move(defaults)](Task task, const std::string&) { return defaults(task); },
            std::move(make)) {}
  RegisteredEstimator(const std::string& type, const std::string& help, const std::vector<std::string>& presets,
                      PresetDefaults of_preset, Make make)
      : Registered<EstimatorEntry>(type, EntryOf(type, help, presets, std::move(of_preset), std::move(make))) {}

 private:
  static EstimatorEntry EntryOf(const std::string& type, const std::string& help,
                                const std::vector<std::string>& presets, PresetDefaults defaults, Make make) {
    const auto read = [type, presets, defaults](const Config& config, Task task) {
      const std::string preset = PresetOf(config, presets);
      return ReadOptions(config, TypedOptions<Options>{type, DefaultsAt(config, [&] { return defaults(task, preset); }),
                                                       preset, presets});
    };
    EstimatorEntry entry;
    entry.help = help;
    entry.make = [read, make = std::move(make)](const Config& config, Task task, const EstimatorContext&) {
      return make(read(config, task).options);
    };
    entry.resolve = [read](const Config& config, Task task, const EstimatorContext&) {
      return ToConfig(read(config, task));
    };
    entry.describe = [presets, defaults](Task task) {
      const std::string preset = presets.empty() ? "" : presets.front();
      return DescribeOptions(TypedOptions<Options>{"", defaults(task, preset), preset, presets});
    };
    return entry;
  }
};

}  // namespace diffsac
