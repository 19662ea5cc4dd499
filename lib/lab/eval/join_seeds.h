#pragma once

#include <vector>

#include "lab/eval/results.h"

namespace diffsac {

/// The results of an experiment with several seeds as one: metrics are means over the seeds, and a problem that all
/// seeds share (one that is read, not drawn) counts once, with the mean of its values. A row that some seeds lack (its
/// network is not there) is of the others. Throws Error where seeds have different conditions.
ExperimentResults JoinSeeds(const std::vector<ExperimentResults>& results);

}  // namespace diffsac
