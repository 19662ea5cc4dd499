#pragma once

#include <map>
#include <string>

#include "lab/files/correspondence_files.h"

namespace diffsac {

/// Pairs that came with their matches.
struct GivenPairs {
  CorrespondenceSet set;
  std::map<std::string, std::string> files = {};  ///< Of the images' names.
  std::size_t of_others = 0;                      ///< Pairs that were left out: of cameras that are not calibrated.
};

/// hloc's matches and features, as data_tools/hloc.py says: a file of matches, or a folder that holds both. Throws
/// Error.
GivenPairs ReadHlocPairs(const std::string& path);

/// The matches of a COLMAP database, or, where it has none, its verified ones: of pairs of cameras that are calibrated,
/// or of all, as they are seen. Throws Error.
GivenPairs ReadColmapPairs(const std::string& path, bool calibrated);

/// Problem::scale_rotation_changes of matches between keypoints whose frames (N × 2: logarithm of the size, angle in
/// radians) are given; empty where those of one image are.
PointMatrix ScaleRotationChangesOf(const PointMatrix& first, const PointMatrix& second, const MatchIndices& matches);

/// A scene's file holds all pairs: where a pair with matches has no similarities, none keeps them.
void KeepAllScaleRotationChangesOrNone(CorrespondenceSet* set);

}  // namespace diffsac
