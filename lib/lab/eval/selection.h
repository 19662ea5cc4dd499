#pragma once

#include <string>
#include <vector>

#include "lab/eval/experiment.h"

namespace diffsac {

/// Keeps the named rows, in the experiment's order, and forgets what refers to others. Throws Error naming the nearest
/// row for an unknown name.
void SelectEstimators(const std::vector<std::string>& names, ExperimentOptions* experiment);

/// The files and folders that the conditions' data is read from; none for generated data.
std::vector<std::string> DataPaths(const ExperimentOptions& experiment);

/// The checkpoints that rows name, each once, whether they are there or not.
std::vector<std::string> Checkpoints(const ExperimentOptions& experiment);

/// Under `missing: leave_out`, takes what is not there into `left_out`: paths of a condition's data, conditions without
/// any of theirs, rows that are for these alone and, unless `any_checkpoint`, rows whose checkpoint is not there.
/// False when no condition or no row is left.
bool LeaveOutMissing(bool any_checkpoint, ExperimentOptions* experiment);

/// What is said of an experiment of which that left nothing, with the first of what it lacks.
std::string NothingIsHere(const ExperimentOptions& experiment);

}  // namespace diffsac
