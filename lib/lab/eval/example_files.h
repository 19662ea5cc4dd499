#pragma once

#include <string>
#include <utility>

#include "lab/eval/results.h"

namespace diffsac {

// What scripts/report draws beside numbers: points of problems, which the data of a run has and its results have not.
// Both are HDF5 files: `json` (the bytes of a text) has a list `examples` with what is known of each problem but its
// points, points-N (rows of a problem's points) and, where it is known, inliers-N (0 or 1) those of its N-th.

/// The kept fits, each with its example, model, labels and errors, and the reverse steps of one.
inline constexpr const char* kFitsFile = "fits.h5";
/// The pairs of two views whose matches report.html shows.
inline constexpr const char* kPairsFile = "pairs.h5";

/// The names of a pair's images: those that the example has, or what its id "scene/img1-img2" says; empty for another.
std::pair<std::string, std::string> ImageNames(const Example& example);

/// Writes fits.h5 into the run's folder, or removes an earlier run's where none were kept. Throws Error.
void WriteFits(const ExperimentResults& results, const std::string& folder);

/// Writes pairs.h5 into the run's folder: of the problems whose inliers some method kept, read again from the
/// conditions' data, those that a page has room for. Of too many these are half the largest errors of the reference
/// row, or of the first that competes, a quarter the smallest, the others evenly spread between. Data that is not there
/// any more is a warning. An earlier run's file goes where there is nothing to show. Throws Error where it cannot be
/// written.
void WritePairs(const ExperimentResults& results, const std::string& folder);

/// At most `most` of these errors' positions: half of them the largest, a quarter the smallest, the rest evenly spread
/// over what lies between. Unknown errors (NaN) count as smallest. Ascending; all where there are no more.
std::vector<std::size_t> LargestSmallestAndSpread(const std::vector<double>& errors, std::size_t most);

}  // namespace diffsac
