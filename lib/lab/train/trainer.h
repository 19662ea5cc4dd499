#pragma once

#include <atomic>
#include <string>

#include "lab/options/options.h"
#include "lab/train/train_options.h"

namespace diffsac {

class ProcessGroup;

struct TrainRequest {
  /// Throws Error for a bad configuration.
  explicit TrainRequest(const Config& config) : options(ReadTrainConfig(config)) {}

  TrainConfig options;
  std::string output;      ///< run folder
  bool resume = false;     ///< continue from output/checkpoints/last.safetensors
  bool overwrite = false;  ///< start anew where another training has been (lab/train/training_folder.h)
  std::string device = "auto";
  int threads = 0;                ///< of LibTorch and of validation; 0: all cores
  ProcessGroup* group = nullptr;  ///< processes that train together (lab/train/distributed.h); null: this one alone
};

enum class TrainOutcome { kFinished, kStopped };

/// Trains the method that the configuration names (diffsac: the paper's Algorithm 1) and writes config.yaml,
/// metrics.csv, training_curve.png, report.html, log.txt and checkpoints/{last,best}.safetensors under request.output.
/// `stop` ends it at the next step with a checkpoint written. A training that is resumed with nothing left to do is
/// finished. Throws Error where the folder is another's (CheckStart), on data that does not fit, and when the loss is
/// not finite: the last good checkpoint is kept. In a group the process of rank 0 writes; when another ends, the rest
/// save what was done (rank 0) and throw Error.
TrainOutcome Train(const TrainRequest& request, const std::atomic<bool>& stop);

}  // namespace diffsac
