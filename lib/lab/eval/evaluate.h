#pragma once

#include <atomic>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "lab/config/make_estimator.h"
#include "lab/config/process.h"
#include "lab/eval/export_colmap.h"
#include "lab/eval/runner.h"

namespace diffsac {

/// What the command line of diffsac_eval says.
struct EvalRequest {
  std::string config_path;
  std::vector<std::string> assignments;  ///< --set
  std::vector<std::string> methods;      ///< --methods; empty: all rows
  int limit = 0;                         ///< --limit: at most so many problems a condition; 0: as configured
  std::string output;                    ///< --output; empty: runs/<name>
  std::int64_t seed = -1;                ///< --seed; negative: as configured, all of its `seeds`
  std::string shard;                     ///< --shard i/n; empty: all problems
  std::string data_root;                 ///< --data: replaces the experiment's data_root
  bool needs = false;                    ///< --needs: only says which folders the experiment reads
  bool rows = false;                     ///< --rows: only says the rows, by their labels
  bool train_missing = false;  ///< --train-missing: networks under runs/ that rows name and that are not there
  std::string training_device = "auto";  ///< Of these: --device where it is given.
  bool update = false;                   ///< --update: nothing is done where the folder holds the results already
  ColmapExport colmap;                   ///< --export-colmap, --export-overwrite
  EstimatorContext context;              ///< --checkpoint, --device, --threads (0: as configured)
};

/// Reads the configuration with the command line on top. Data and networks may be missing. Throws Error.
ExperimentOptions ReadRequest(const EvalRequest& request);

/// Runs the experiment, writes its folder (run_files.h) and prints the table to `out`; with several seeds once with
/// each, in FOLDER/seed_N, passing over those that are made already: interrupted, the same call goes on. Returns
/// kExitOk, or kExitInterrupted after writing partial results when `stop` turned true. Throws Error for bad input.
int Evaluate(const EvalRequest& request, const TraceConfidence& trace, const std::atomic<bool>& stop,
             std::ostream& out);

}  // namespace diffsac
