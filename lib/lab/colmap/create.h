#pragma once

#include <map>
#include <string>
#include <vector>

#include "lab/colmap/database.h"

namespace diffsac {

/// An image of a new database.
struct NewColmapImage {
  std::string name;        ///< File, with the folders before it.
  std::size_t camera = 0;  ///< Index of NewColmapDatabase::cameras.
  PointMatrix keypoints;   ///< N × 2, COLMAP's pixels: the centre of the first one is (0.5, 0.5).
  PointMatrix frames;      ///< N × 2: the logarithm of the scale, the orientation in radians.
};

/// What a new database holds. The id of an image is its index plus one.
struct NewColmapDatabase {
  std::vector<ColmapCamera> cameras;
  std::vector<NewColmapImage> images;
  std::map<ColmapPair, MatchIndices> matches;  ///< By the images' ids, the smaller one first.
};

/// Writes a database of COLMAP 3.8's schema (https://colmap.github.io/database.html) without descriptors and two-view
/// geometries (WriteGeometries adds these), whole or not at all, in place of an older file. Throws Error.
void CreateColmapDatabase(const std::string& path, const NewColmapDatabase& content);

}  // namespace diffsac
