#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "lab/config/run_directory.h"
#include "lab/options/options.h"

namespace diffsac {

struct TrainRequest;

/// The configuration that a folder's training goes on with unless it is told otherwise: the folder's config.yaml, or,
/// where that is not the training's, what its last checkpoint says. Throws Error where there is nothing to go on with.
Config ConfigurationToResume(const std::string& folder);

/// Throws Error, and touches nothing, unless a training may start in request.output as it is asked to:
/// - a new one where there are no networks and nothing that it would replace, but for what a start that came to nothing
///   leaves (config.yaml, log.txt);
/// - with `overwrite` anywhere;
/// - with `resume` where there is a checkpoint of the same configuration. Keys that no step and no validation needs may
///   change (intervals, `name`, `train.workers`), and `train.iterations` to any number above that of the steps done.
///
/// Of a group, the process that writes looks whether a folder is used; all look at what they resume.
void CheckStart(const TrainRequest& request);

/// The folder that a training writes to, and no other process while this lives. Processes that do not write have it as
/// well, without a lock.
class TrainingFolder {
 public:
  /// CheckStart, and creates the folder; nothing in it changes.
  explicit TrainingFolder(const TrainRequest& request);

  const std::string& path() const { return path_; }
  /// Of "last.safetensors" or "best.safetensors".
  std::string Checkpoint(const std::string& name) const;
  /// What differs from the configuration of the training that is resumed ("train.iterations: 30, now 60"), or nothing.
  const std::string& changes() const { return changes_; }

  /// All else is ready: with `overwrite` removes what an earlier training left (not log.txt, which grows, nor files
  /// that are no training's), then writes config.yaml. Only in the process that writes.
  void Begin(const std::string& resolved_config);

 private:
  std::string path_;
  bool overwrite_;
  std::uint64_t seed_;
  std::optional<RunLock> lock_;
  std::string changes_;
};

}  // namespace diffsac
