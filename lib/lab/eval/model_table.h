#pragma once

#include "lab/eval/report.h"

namespace diffsac {

/// The lines or planes that were found in a person's own points (data of type point_sets), a row a model: normal,
/// offset, inliers and noise, in the unit of the points. No rows for other data, and where no estimates are kept.
Table ModelTable(const ExperimentResults& results);

}  // namespace diffsac
