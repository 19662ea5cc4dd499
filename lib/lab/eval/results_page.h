#pragma once

#include <string>

#include "lab/eval/experiment.h"

namespace diffsac {

/// Whether a folder holds what running the experiment would give: the whole results of the same configuration, newer
/// than this program and than the networks that rows name.
bool IsMade(const ExperimentOptions& experiment, const std::string& folder);

}  // namespace diffsac
