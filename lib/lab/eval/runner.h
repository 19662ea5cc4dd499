#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "lab/config/table_row.h"
#include "lab/eval/results.h"
#include "lab/options/config.h"

namespace diffsac {

/// Builds a row (MakeRow, or a test's own).
using RowFactory = std::function<TableRow(const Config& row, Task task)>;

struct RunInputs {
  RowFactory make_row;
  TraceConfidence trace;                    ///< May be empty.
  const std::atomic<bool>* stop = nullptr;  ///< Polled before each problem or batch.
  Shard shard = {};                         ///< Only these problems; pictures of examples are kept by the first shard.
};

/// The seed of a problem, by its scene and id: the same for every method, condition, batch and thread count, and
/// whatever else runs or stands in the list beside it.
std::uint64_t ProblemSeed(std::uint64_t experiment_seed, const Example& problem);

/// The line of problems.csv of an estimate.
ProblemRecord MakeRecord(const ExperimentOptions& experiment, const Example& example, const Estimate& estimate);

/// Runs every method on the same problems of every condition. Methods without batches run in parallel over problems,
/// batched ones batch after batch. Results depend on the experiment alone, times excepted. When `*stop` turns true the
/// running problems or batch are finished and the rest is left out (`partial`).
/// Throws Error for wrong data or method options before anything runs.
ExperimentResults RunExperiment(const ExperimentOptions& experiment, const RunInputs& inputs);

}  // namespace diffsac
