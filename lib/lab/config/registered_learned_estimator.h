#pragma once

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>

#include "diffsac/estimate/learned_model.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/estimator_registry.h"
#include "lab/options/config.h"
#include "lab/options/options.h"

namespace diffsac {

/// A row with a network: its own keys override the checkpoint's `inference` group, or the preset that it names, so that
/// it says only what it changes. Without a type: the keys beside type and checkpoint, for their description.
template <class Options>
struct CheckpointRow {
  Options options;
  Task task;
  std::string preset;
  std::vector<std::string> presets;
  std::string type = {};
  std::string checkpoint = {};
  void Bind(OptionsBinder& b) {
    if (!type.empty()) b.Choice("type", type, std::vector<std::string>{type});
    TypedOptions<Options>::BindPreset(b, presets, &preset);
    if (!type.empty()) b.Field("checkpoint", checkpoint);
    BindModel(b, task, &options.model);
    BindAny(b, options);
  }
};

/// The row's checkpoint: --checkpoint, for the rows of the method that trained it, or else the key. Throws Error when
/// there is neither.
TrainedConfig TrainedConfigOf(const Config& row, Task task, const EstimatorContext& context);

/// The row without what it repeats of `inherited`: a resolved row repeats everything.
Config KeysThatDiffer(const Config& row, const Config& inherited);

/// A key that a row may write, and whether it changes anything there. For what depends on the network; what depends on
/// other keys alone is the binder's (OnlyIf).
struct RowKey {
  const char* key;
  bool acts;
  const char* reason;             ///< Why it does not, for the message.
  const char* neutral = nullptr;  ///< A value that may be written all the same: it switches off what is inherited.
};

/// Throws Error with the line of the first key that the row itself writes and that cannot act there. What a row
/// inherits from its checkpoint is no error.
void CheckRowKeys(const Config& row, std::initializer_list<RowKey> keys);

/// That for the keys that all learned rows share.
void CheckSharedKeys(const Config& row, const LearnedModel& network);

/// Sets of options that a row may name in place of the checkpoint's `inference` group, which is the first, "default".
template <class Options>
struct LearnedPresets {
  std::vector<std::string> names = {};
  std::function<Options(Task, const std::string& preset)> options = {};
};

/// A row with a network, registered at the end of its method's file:
/// ```
/// const RegisteredLearnedEstimator<DiffsacEstimator, DiffsacOptions, DiffsacModel> kDiffsac(
///     "diffsac", "Minimal sets guided by ...", DiffsacOptions(), Load);
/// ```
/// Row: made of a network, Options and a number of threads. load: called with the checkpoint's configuration, the row's
/// options and what the program says (its device). The name is that of the training's `method` as well. CheckRow(keys,
/// options, network) refuses own keys that cannot act.
template <class Row, class Options, class Network>
struct RegisteredLearnedEstimator : Registered<EstimatorEntry> {
  using Load =
      std::function<std::shared_ptr<const Network>(const TrainedConfig&, const Options&, const EstimatorContext&)>;
  RegisteredLearnedEstimator(const std::string& type, const std::string& help, const Options& defaults, Load load,
                             const LearnedPresets<Options>& presets = {})
      : Registered<EstimatorEntry>(type, EntryOf(help, defaults, std::move(load), presets)) {}

 private:
  using Presets = LearnedPresets<Options>;

  /// What a row's own keys override: its preset, or the checkpoint's `inference` group over the defaults.
  static Options Inherited(const TrainedConfig& trained, const Options& defaults, const Presets& presets,
                           const std::string& preset) {
    const bool named = !presets.names.empty() && preset != presets.names.front();
    Options options =
        named ? presets.options(trained.task, preset) : ReadStoredOptions(ConfigOf(trained).Sub("inference"), defaults);
    options.model = trained.model;
    return options;
  }

  static CheckpointRow<Options> Read(const Config& config, const TrainedConfig& trained, const Options& inherited,
                                     const Presets& presets) {
    auto row = ReadOptions(config, CheckpointRow<Options>{inherited, trained.task, PresetOf(config, presets.names),
                                                          presets.names, trained.method});
    row.checkpoint = trained.checkpoint;
    return row;
  }

  static EstimatorEntry EntryOf(const std::string& help, const Options& defaults, Load load, const Presets& presets) {
    const auto inherited_of = [defaults, presets](const Config& config, const TrainedConfig& trained) {
      return Inherited(trained, defaults, presets, PresetOf(config, presets.names));
    };
    EstimatorEntry entry;
    entry.help = help;
    entry.make = [inherited_of, presets, load = std::move(load)](const Config& config, Task task,
                                                                 const EstimatorContext& context) {
      const TrainedConfig trained = TrainedConfigOf(config, task, context);
      const Options inherited = inherited_of(config, trained);
      const Options options = Read(config, trained, inherited, presets).options;
      const auto network = load(trained, options, context);
      CheckRow(KeysThatDiffer(config, ToConfig(inherited)), options, *network);
      return std::make_unique<Row>(network, options, context.threads);
    };
    entry.resolve = [inherited_of, presets](const Config& config, Task task, const EstimatorContext& context) {
      const TrainedConfig trained = TrainedConfigOf(config, task, context);
      return ToConfig(Read(config, trained, inherited_of(config, trained), presets));
    };
    entry.describe = [defaults, presets](Task task) {
      const std::string preset = presets.names.empty() ? "" : presets.names.front();
      return DescribeOptions(CheckpointRow<Options>{defaults, task, preset, presets.names});
    };
    return entry;
  }
};

}  // namespace diffsac
