#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "diffsac/problem/tasks.h"
#include "diffsac/estimators/learned_model.h"
#include "diffsac/lab/estimator_registry.h"

namespace diffsac {

/// What a row with a network may write beside its type and checkpoint.
template <class Options>
struct LearnedKeys {
  Options options;
  Task task;
  void Bind(OptionsBinder& b) {
    BindModel(b, task, &options.model);
    options.Bind(b);
  }
};

/// A row with a network: its own keys override the checkpoint's `inference` group, so that it says only what it
/// changes.
template <class Options>
struct CheckpointRow {
  std::string type;
  std::string checkpoint;
  LearnedKeys<Options> keys;
  void Bind(OptionsBinder& b) {
    b.Choice("type", type, std::vector<std::string>{type});
    b.Field("checkpoint", checkpoint);
    keys.Bind(b);
  }
};

/// The row's checkpoint: --checkpoint, for the rows of the method that trained it, or else the key. Throws Error when
/// there is neither.
TrainedConfig TrainedConfigOf(const Config& row, Task task, const EstimatorContext& context);

/// The row without what it repeats of `inherited`: a resolved row repeats everything.
Config KeysThatDiffer(const Config& row, const Config& inherited);

/// A row with a network, registered at the end of its method's file:
/// ```
/// const RegisteredLearnedEstimator<DiffsacEstimator, DiffsacOptions, DiffsacNetwork> kDiffsac(
///     "diffsac", "Minimal sets guided by ...", DiffsacOptions(), LoadNetwork);
/// ```
/// Row: made of a network, Options and a number of threads. load: called with the checkpoint's configuration, the row's
/// options and what the program says (its device). The name is that of the training's `method` as well. CheckRow(keys,
/// options, network) refuses own keys that cannot act.
template <class Row, class Options, class Network>
struct RegisteredLearnedEstimator : Registered<EstimatorEntry> {
  using Load =
      std::function<std::shared_ptr<const Network>(const TrainedConfig&, const Options&, const EstimatorContext&)>;
  RegisteredLearnedEstimator(const std::string& type, const std::string& help, const Options& defaults, Load load)
      : Registered<EstimatorEntry>(type, EntryOf(help, defaults, std::move(load))) {}

 private:
  /// The checkpoint's `inference` group over the defaults.
  static Options Inherited(const TrainedConfig& trained, const Options& defaults) {
    Options options = ReadStoredOptions(trained.config.Sub("inference"), defaults);
    options.model = trained.model;
    return options;
  }

  static CheckpointRow<Options> Read(const Config& config, const TrainedConfig& trained, const Options& inherited) {
    auto row = ReadOptions(config, CheckpointRow<Options>{trained.method, {}, {inherited, trained.task}});
    row.checkpoint = trained.checkpoint;
    return row;
  }

  static EstimatorEntry EntryOf(const std::string& help, const Options& defaults, Load load) {
    EstimatorEntry entry;
    entry.help = help;
    entry.make = [defaults, load = std::move(load)](const Config& config, Task task, const EstimatorContext& context) {
      const TrainedConfig trained = TrainedConfigOf(config, task, context);
      const Options inherited = Inherited(trained, defaults);
      const Options options = Read(config, trained, inherited).keys.options;
      const auto network = load(trained, options, context);
      CheckRow(KeysThatDiffer(config, ToConfig(inherited)), options, *network);
      return std::make_unique<Row>(network, options, context.threads);
    };
    entry.resolve = [defaults](const Config& config, Task task, const EstimatorContext& context) {
      const TrainedConfig trained = TrainedConfigOf(config, task, context);
      return ToConfig(Read(config, trained, Inherited(trained, defaults)));
    };
    entry.describe = [defaults](Task task) { return DescribeOptions(LearnedKeys<Options>{defaults, task}); };
    entry.options = typeid(Options);
    return entry;
  }
};

}  // namespace diffsac
