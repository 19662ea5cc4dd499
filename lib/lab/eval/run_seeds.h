#pragma once

#include <atomic>
#include <iosfwd>
#include <vector>

#include "lab/eval/evaluate.h"
#include "lab/eval/results.h"

namespace diffsac {

/// The results of an experiment with several seeds as one: metrics are means over the seeds, and a problem that all
/// seeds share (one that is read, not drawn) counts once, with the mean of its values. A row that some seeds lack (its
/// network is not there) is of the others. Throws Error where seeds have different conditions.
ExperimentResults JoinSeeds(const std::vector<ExperimentResults>& results);

/// Runs the experiment once with each of its seeds in a folder of its own, FOLDER/points/seed=1, passes over those that
/// are made already, and writes the table of all to FOLDER. Returns what Evaluate returns; interrupted, the same call
/// goes on. Throws Error.
int EvaluateSeeds(const EvalRequest& request, const ExperimentOptions& experiment, const TraceConfidence& trace,
                  const std::atomic<bool>& stop, std::ostream& out);

}  // namespace diffsac
