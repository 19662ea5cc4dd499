#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lab/truth/example.h"

namespace diffsac {

/// How many matches a picture shows.
struct PictureCounts {
  int matches = 0;
  int inliers = 0;  ///< Within the threshold of the truth; -1 where it is not known.
};

/// Draws a pair's images side by side, at most 2400 pixels wide together, with a point for each match and lines for at
/// most 60 inliers and as many outliers, evenly spaced: inliers in green, outliers in orange, all in blue where the
/// truth is not known; a legend below. Inliers are matches within `threshold_px` of the true model, or labelled ones
/// where there is none.
/// `images`: the folder of the images (or of a folder `images`), named as in the pair's id. Empty: white canvases of
/// the sizes that the pair knows. Matches are drawn where they are stored, without lens distortion. Throws Error:
/// images or sizes that are missing, a file that cannot be written.
PictureCounts DrawMatches(const Example& pair, double threshold_px, const std::string& images, const std::string& path);

/// Draws two image files in the same way with the matches of an estimate: its inliers with lines for at most 60 of
/// them, the others as points, `caption` in the legend. points: N × 4, pixels of the files. The format is what `path`
/// ends in. Throws Error.
void DrawInliers(const std::string& image1, const std::string& image2, const PointMatrix& points,
                 const std::vector<std::uint8_t>& inliers, const std::string& caption, const std::string& path);

}  // namespace diffsac
