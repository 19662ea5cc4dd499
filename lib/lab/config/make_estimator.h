#pragma once

#include <memory>
#include <string>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/config/table_row.h"
#include "lab/options/options.h"

namespace diffsac {

/// What a program says about all its methods.
struct EstimatorContext {
  std::string checkpoint_override;  ///< --checkpoint: replaces that of the rows of its method
  std::string device = "cpu";
  int threads = 0;  ///< 0: all cores
};

/// Builds the row that `type` names. Throws Error: unknown type (with the nearest), bad option, bad checkpoint, a
/// device that is not there.
TableRow MakeRow(const Config& config, Task task, const EstimatorContext& context);

/// The same for problems that are no table's. Throws Error as well for a row that is shown the example.
std::unique_ptr<RobustEstimator> MakeEstimator(const Config& config, Task task, const EstimatorContext& context);

/// The row with every key filled in, `type` first: its defaults for the task, the checkpoint's `inference` group, its
/// own keys. Makes the same method. Throws as MakeEstimator does, but loads no network.
Config ResolvedRow(const Config& config, Task task, const EstimatorContext& context);

}  // namespace diffsac
