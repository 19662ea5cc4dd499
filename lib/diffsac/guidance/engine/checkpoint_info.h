#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "diffsac/core/safetensors.h"

namespace diffsac {

/// Sums of the parts of the loss over the steps since the last row of metrics.
struct LossSums {
  std::vector<double> sums;
  std::int64_t steps = 0;
};

/// What a checkpoint says about itself.
struct CheckpointInfo {
  std::string method, task;    ///< That the network was trained by and for.
  std::string config;          ///< The resolved training configuration, JSON (YAML in files of earlier versions).
  std::string git_revision;    ///< Of the program that wrote it.
  std::int64_t iteration = 0;  ///< Optimiser steps done. Data, noise and times of each step are drawn from
                               ///< (seed, iteration), so this is the whole random state.
  std::uint64_t seed = 0;
  double best_validation = -1;  ///< Best validation mAA so far, −1 before the first.
  LossSums losses = {};         ///< Only where training can resume; none in files of earlier versions.
};

// A checkpoint is a safetensors file (core/safetensors.h; docs/reliability.md): tensors `average.*` and, where training
// can resume, `network.*` and `optimizer.*`, named by the network's parameters, and the info as the file's metadata.

/// What the names of a network's weights begin with, in checkpoints and in files that are imported, and of the weights'
/// moving average, which inference takes.
inline constexpr const char* kNetworkTensors = "network.";
inline constexpr const char* kAverageTensors = "average.";

/// Opens a checkpoint, of a path or in the library (core/embedded_models.h), whose info is then read from it. Throws
/// Error when the file is missing, damaged or of another program or version.
SafetensorsFile OpenCheckpoint(const std::string& path);
CheckpointInfo ReadInfo(const SafetensorsFile& file);
/// A number of the info that is not negative. Throws Error naming file and key.
std::int64_t ReadCount(const SafetensorsFile& file, const char* key);
/// Both of a file that is not needed further.
CheckpointInfo ReadCheckpointInfo(const std::string& path);

/// Makes JSON of configurations that are not, where a program has such a reader (registered as "yaml").
struct CheckpointConfigReader {
  static constexpr const char* kKind = "reader of checkpoints' configurations";
  std::function<std::string(const std::string& text, const std::string& name)> to_json;
};

/// What stands for a checkpoint's configuration in messages.
std::string ConfigName(const std::string& checkpoint);
/// The training configuration of a checkpoint as JSON. Throws Error, naming the file, when it cannot be read.
std::string ConfigText(const CheckpointInfo& info, const std::string& path);

/// Throws Error, naming the file, unless it holds at least `least` averaged weights. Asked before a network is made as
/// a checkpoint's configuration says, so that a small file cannot ask for a large one.
void RequireWeights(const std::string& path, std::int64_t least);

/// Adds what ReadInfo reads, but for the sums of losses.
void WriteInfo(const CheckpointInfo& info, SafetensorsWriter* writer);
void WriteLossSums(const LossSums& losses, SafetensorsWriter* writer);

}  // namespace diffsac
