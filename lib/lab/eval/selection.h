#pragma once

#include <atomic>
#include <string>
#include <string_view>
#include <vector>

#include "lab/eval/experiment.h"

namespace diffsac {

/// Keeps the named rows, in the experiment's order. Throws Error naming the nearest row for an unknown name.
void SelectEstimators(const std::vector<std::string>& names, ExperimentOptions* experiment);

/// The files and folders that the conditions' data is read from; none for generated data.
std::vector<std::string> DataPaths(const ExperimentOptions& experiment);

/// The checkpoints and recordings that rows name, each once, whether they are there or not.
std::vector<std::string> RowFiles(const ExperimentOptions& experiment);

/// Under `missing: leave_out`, takes what is not there into `left_out`: paths of a condition's data, conditions without
/// any of theirs, rows that are for these alone and, unless `any_checkpoint`, rows whose checkpoint is not there.
/// False when no condition or no row is left.
bool LeaveOutMissing(bool any_checkpoint, ExperimentOptions* experiment);

/// What is said of an experiment of which that left nothing, with the first of what it lacks.
std::string NothingIsHere(const ExperimentOptions& experiment);

/// Between the name of a training and the seed that it was made with, in the name of a network.
inline constexpr std::string_view kTrainingSeed = "_seed_";

/// A network that a row names as runs/NAME/checkpoints/..., that is not there or whose training was not finished, and
/// the training that makes it.
struct MissingNetwork {
  std::string name;
  std::string checkpoint;
  std::string config;  ///< The training configuration named NAME; empty where there is none.
  /// Of a network named NAME_seed_N, which the configuration NAME makes with another seed: N.
  std::string seed = {};
};

/// Those of an experiment's rows. Training configurations are looked for below `configs`, by their `name`.
std::vector<MissingNetwork> MissingNetworks(const ExperimentOptions& experiment,
                                            const std::string& configs = "configs");

/// What an experiment reads and can be prepared: the folders of its data and, where they are to be `trained`, those
/// below runs/ that the trainings of missing networks read.
std::vector<std::string> NeededFolders(const ExperimentOptions& experiment, bool trained,
                                       const std::string& configs = "configs");

/// Trains them one after the other with the program beside this one, each where an earlier run of its stopped; the
/// programs' output goes to runs/NAME.log. A network that cannot be trained is warned of. A training ends with this
/// process, however that ends. device: as diffsac_train takes it. False: interrupted, by `stop` or by itself.
bool TrainNetworks(const std::vector<MissingNetwork>& networks, const std::string& device,
                   const std::atomic<bool>& stop);

/// The program and its arguments that train a network which has a configuration.
std::vector<std::string> TrainingCommand(const MissingNetwork& network, const std::string& device);

}  // namespace diffsac
