#pragma once

#include <memory>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/methods/diffsac_method.h"
#include "diffsac/train/train_options.h"

namespace diffsac {

/// mAA of the whole estimator on fixed validation problems (split "validation"), for each outlier ratio.
class Validation {
 public:
  Validation(Task task, const Config& data, const ValidationOptions& options, std::uint64_t seed);
  std::vector<double> Run(const DiffsacMethod& method) const;

 private:
  ValidationOptions options_;
  std::uint64_t seed_;
  std::vector<std::vector<Example>> examples_;
};

}  // namespace diffsac
