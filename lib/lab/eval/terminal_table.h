#pragma once

#include <iosfwd>

#include "lab/eval/results.h"

namespace diffsac {

/// A line for each row, by condition its accuracy (mAA, or recall of several structures; without truth the median
/// number of inliers), for lines and planes the median error, and milliseconds. Accuracies and errors are unweighted
/// means over the scenes; milliseconds are medians over the problems. Then, of own points, the lines or planes found.
void PrintTable(const ExperimentResults& results, std::ostream& out);

}  // namespace diffsac
