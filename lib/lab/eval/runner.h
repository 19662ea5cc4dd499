#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "lab/config/make_estimator.h"
#include "lab/eval/results.h"
#include "lab/options/config.h"

namespace diffsac {

/// Builds a row (MakeRow, or a test's own).
using RowFactory = std::function<TableRow(const Config& row, Task task)>;

struct RunInputs {
  RowFactory make_row;
  TraceConfidence trace;                    ///< May be empty.
  const std::atomic<bool>* stop = nullptr;  ///< Polled before each problem or batch.
  Shard shard = {};                         ///< Only these problems.
};

/// The seed of a problem, by its scene and id: the same for every method, condition, batch and thread count, and
/// whatever else runs or stands in the list beside it.
std::uint64_t ProblemSeed(std::uint64_t experiment_seed, const Example& problem);

/// The line of problems.csv of an estimate; `whole` as in RecordOf.
ProblemRecord MakeRecord(const ExperimentOptions& experiment, const Example& example, const Estimate& estimate,
                         bool whole = true);

/// The numbers below `count` that a shard takes, ascending. `batch` following ones always stay together, every
/// shard.count-th group of them is this shard's: a network sees the same batches in any sharding, so that its outputs
/// are the same to the last bit. Where there are fewer batches than shards some shards get none.
std::vector<std::size_t> ShardPositions(std::size_t count, std::size_t batch, const Shard& shard);

/// Runs every method on the same problems of every condition. Methods without batches run in parallel over problems,
/// batched ones batch after batch. Results depend on the experiment alone, times excepted. When `*stop` turns true the
/// running problems or batch are finished and the rest is left out (`partial`).
/// Throws Error for wrong data or method options before anything runs.
ExperimentResults RunExperiment(const ExperimentOptions& experiment, const RunInputs& inputs);

}  // namespace diffsac
