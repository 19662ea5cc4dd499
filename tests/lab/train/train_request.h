#pragma once

#include <atomic>
#include <string>
#include <utility>
#include <vector>

#include "diffsac/core/options.h"
#include "lab/config/yaml.h"
#include "lab/train/trainer.h"

namespace diffsac {

/// For trainings that nothing interrupts.
inline const std::atomic<bool> kNever{false};

/// A training on one thread of the CPU; `changes` as `--set` takes them.
inline TrainRequest OneThread(Config config, const std::string& output, const std::vector<std::string>& changes = {}) {
  for (const auto& change : changes) SetYaml(&config, change);
  TrainRequest request(config);
  request.output = output;
  request.device = "cpu";
  request.threads = 1;
  return request;
}

}  // namespace diffsac
