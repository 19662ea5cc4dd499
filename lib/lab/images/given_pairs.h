#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "lab/files/correspondence_files.h"
#include "lab/images/run_pairs.h"

namespace diffsac {

/// Writes a scene of correspondences that came with their images: the set that `read` gives in the folder
/// `request.output`/`name`, unless it is there already (and is not to be overwritten) or `stop` turned true. Says so,
/// and counts it in `result`. Throws Error.
void WriteScene(const PairsRequest& request, const std::string& name, const std::function<CorrespondenceSet()>& read,
                const std::atomic<bool>& stop, PrepareResult* result);

/// Problem::similarities of matches between keypoints whose frames (N × 2: logarithm of the size, angle in radians) are
/// given; empty where those of one image are.
PointMatrix SimilaritiesOf(const PointMatrix& first, const PointMatrix& second, const MatchIndices& matches);

/// A scene's file holds all pairs: where a pair with matches has no similarities, none keeps them.
void KeepAllSimilaritiesOrNone(CorrespondenceSet* set);

}  // namespace diffsac
