#pragma once

#include <vector>

#include "lab/eval/metric_table.h"

namespace diffsac {

/// The tables of an experiment over several structures (docs/metrics.md#several-structures): misclassification over all
/// problems, mean with the costs and median, recall, what the minimal sets hold.
std::vector<MetricTable> StructureKinds(const ExperimentResults& results);

/// What a note under them says of the metrics.
inline constexpr const char* kStructureNote =
    " Misclassification: per cent of points with a wrong label, over all problems; recall: share of the true "
    "structures "
    "that are found.";

}  // namespace diffsac
