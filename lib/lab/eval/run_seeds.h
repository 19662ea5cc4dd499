#pragma once

#include <atomic>
#include <iosfwd>

#include "lab/eval/evaluate.h"

namespace diffsac {

/// Runs the experiment once with each of its seeds in a folder of its own, FOLDER/points/seed=1, passes over those that
/// are made already, and writes the table of all to FOLDER. Returns what Evaluate returns; interrupted, the same call
/// goes on. Throws Error.
int EvaluateSeeds(const EvalRequest& request, const ExperimentOptions& experiment, const TraceConfidence& trace,
                  const std::atomic<bool>& stop, std::ostream& out);

}  // namespace diffsac
