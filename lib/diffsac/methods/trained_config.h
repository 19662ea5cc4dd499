#pragma once

#include <cstdint>
#include <string>

#include "diffsac/core/options.h"
#include "diffsac/data/problem.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// The training configuration that a checkpoint carries.
struct TrainedConfig {
  Config config;
  std::uint64_t seed = 0;
  TrainingFacts facts;  ///< Without the number of parameters, which the network knows.
};

/// Throws Error naming the file when it is no checkpoint, or was trained by another method ("diffsac" where it does not
/// say) or for another task.
TrainedConfig ReadTrainedConfig(const std::string& checkpoint, const std::string& method, Task task);

/// The method that trained a checkpoint. Throws Error naming the file when it is none.
std::string TrainedMethod(const std::string& checkpoint);

}  // namespace diffsac
