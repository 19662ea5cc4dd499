#pragma once

#include <vector>

#include "lab/eval/report.h"

namespace diffsac {

/// The tables of an experiment, from the report's metrics and differences: mAA (with hypotheses and milliseconds a
/// problem, medians over all problems) and the median error; for data without ground truth the median number of inliers
/// instead. With several scenes the first is the unweighted mean over them, followed by mAA over all pairs, and there
/// is a table by scene for each condition. Two views: rotation and translation on their own, exact AUC and failures. Of
/// several structures misclassification, recall and minimal sets instead (structure_tables.h). Last the experiment's
/// comparisons, the effects of its factors, its strata, ours beside the paper's, and what learned rows were trained on.
std::vector<Table> MakeTables(const Report& report);

/// The largest number of scenes that a condition has.
std::size_t MostScenes(const ExperimentResults& results);

}  // namespace diffsac
