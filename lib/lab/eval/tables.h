#pragma once

#include <vector>

#include "lab/eval/report.h"

namespace diffsac {

/// The tables of an experiment, from the report's metrics and differences: mAA (with hypotheses and milliseconds a
/// problem, medians over all problems) and the median error; for data without ground truth the median number of inliers
/// instead. With several scenes the first is the unweighted mean over them, followed by mAA over all pairs, and there
/// is a table by scene for each condition. Two views: rotation and translation on their own, exact AUC and failures. Of
/// several structures misclassification, recall and minimal sets instead (structure_tables.h). Of a person's own points
/// the models. What results.json has beside them, comparisons, effects, strata, the paper's values beside ours, is laid
/// out by scripts/report.
std::vector<Table> MakeTables(const Report& report);

/// The largest number of scenes that a condition has.
std::size_t MostScenes(const ExperimentResults& results);

}  // namespace diffsac
