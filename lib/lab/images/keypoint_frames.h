#pragma once

#include "lab/files/correspondence_files.h"

namespace diffsac {

/// Problem::similarities of matches between keypoints whose frames (N × 2: logarithm of the size, angle in radians) are
/// given; empty where those of one image are.
PointMatrix SimilaritiesOf(const PointMatrix& first, const PointMatrix& second, const MatchIndices& matches);

/// A scene's file holds all pairs: where a pair with matches has no similarities, none keeps them.
void KeepAllSimilaritiesOrNone(CorrespondenceSet* set);

}  // namespace diffsac
