#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "diffsac/diffsac.h"
#include "lab/files/segment_files.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// A grey image in colour, a little lighter, so that what is drawn on it stands out.
cv::Mat LightImage(const cv::Mat& gray);

/// Writes the whole file, in the format that `path` ends in, in place of what is there; makes the folder kPictureFolder
/// (image_source.h). Throws Error as CheckPictureName does, and where the file cannot be written.
void WritePicture(const cv::Mat& image, const std::string& path);

/// Throws Error unless WritePicture knows the format that `path` ends in.
void CheckPictureName(const std::string& path);

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

/// A grey image, at most 1600 pixels wide or high, with its segments in the colour of their vanishing point (grey: of
/// none), the horizon, the vanishing points that are in the picture, and a legend below. labels: of each vanishing
/// point, for the legend; colours: "#RRGGBB", as many as they.
cv::Mat DrawVanishingPoints(const cv::Mat& gray, const PointMatrix& segments, const VanishingPointsEstimate& estimate,
                            const std::vector<std::string>& labels, const std::vector<std::string>& colours);

}  // namespace diffsac
