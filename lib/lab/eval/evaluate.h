#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "lab/config/exit_codes.h"
#include "lab/config/make_estimator.h"
#include "lab/eval/export_colmap.h"
#include "lab/eval/runner.h"

namespace diffsac {

/// Processes that share an experiment's work. Each takes a shard, that of rank 0 joins and writes them.
struct WorkGroup {
  int rank = 0;  ///< In [0, size).
  int size = 1;
  int threads = 0;  ///< Of a process, unless it is told otherwise; 0: all cores.
  /// The texts of all processes by rank, at rank 0; nothing elsewhere. All processes call it.
  std::function<std::vector<std::string>(const std::string& text)> gather;
};

/// What the command line of diffsac_eval says.
struct EvalRequest {
  std::string config_path;
  std::vector<std::string> assignments;  ///< --set
  std::vector<std::string> methods;      ///< --methods; empty: all rows
  int limit = 0;                         ///< --limit: at most so many problems a condition; 0: as configured
  std::string output;                    ///< --output; empty: runs/<name>
  std::int64_t seed = -1;                ///< --seed; negative: as configured, all of its `seeds`
  std::string shard;                     ///< --shard i/n; empty: all problems
  std::vector<std::string> merge;        ///< --merge: folders of shards to join; then only `output` counts beside it
  std::string data_root;                 ///< --data: replaces the experiment's data_root
  bool needs = false;                    ///< --needs: only says which folders the experiment reads
  bool rows = false;                     ///< --rows: only says the rows, by their labels, those of the paper included
  bool train_missing = false;  ///< --train-missing: networks under runs/ that rows name and that are not there
  std::string training_device = "auto";  ///< Of these: --device where it is given.
  bool update = false;                   ///< --update: nothing is done where the folder holds the results already
  ColmapExport colmap;                   ///< --export-colmap, --export-overwrite
  EstimatorContext context;              ///< --checkpoint, --device, --threads (0: as configured)
  std::optional<WorkGroup> group;        ///< Nothing: this process alone.
};

/// Reads the configuration with the command line on top. Data and networks may be missing. Throws Error.
ExperimentOptions ReadRequest(const EvalRequest& request);

/// Runs the experiment, writes the folder and prints the tables to `out`. A shard's folder holds its part of
/// problems.csv and what MergeFolders needs instead of tables. Returns kExitOk, or kExitInterrupted after writing
/// partial results when `stop` turned true. Throws Error for bad input.
int Evaluate(const EvalRequest& request, const TraceConfidence& trace, const std::atomic<bool>& stop,
             std::ostream& out);

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
