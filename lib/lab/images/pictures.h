#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "diffsac/diffsac.h"
#include "lab/files/segment_files.h"
#include "lab/ground_truth/example.h"
#include "lab/images/image_source.h"

namespace diffsac {

/// A grey image in colour, a little lighter, so that what is drawn on it stands out.
cv::Mat LightImage(const cv::Mat& gray);

/// Writes the whole file, in the format that `path` ends in, in place of what is there; makes the folder kPictureFolder
/// (image_source.h). Throws Error as CheckPictureName does, and where the file cannot be written.
void WritePicture(const cv::Mat& image, const std::string& path);

/// Throws Error unless WritePicture knows the format that `path` ends in.
void CheckPictureName(const std::string& path);

/// An entry of a legend.
struct LegendEntry {
  std::string text;
  cv::Scalar colour;    ///< Blue, green, red.
  bool dashed = false;  ///< In black and white.
};

/// An image with entries from left to right below it, in as many rows as they need.
cv::Mat WithLegend(const cv::Mat& image, const std::vector<LegendEntry>& entries);

/// Draws two image files side by side, at most 2400 pixels wide together, with the matches of an estimate: its inliers
/// in green with lines for at most 60 of them, evenly spaced, the others as orange points; a legend with `caption`
/// below. points: N × 4, pixels of the files. The format is what `path` ends in. Throws Error.
void DrawInliers(const std::string& image1, const std::string& image2, const PointMatrix& points,
                 const std::vector<std::uint8_t>& inliers, const std::string& caption, const std::string& path);

/// A grey image, at most 1600 pixels wide or high, with its segments in the colour of their vanishing point (grey: of
/// none), the horizon, the vanishing points that are in the picture, and a legend below.
cv::Mat DrawVanishingPoints(const cv::Mat& gray, const PointMatrix& segments, const VanishingPointsEstimate& estimate);

/// The file of a scene's folder that holds small copies of its images, for pictures below the matches: by the image's
/// name the bytes of a JPEG file (uint8), its longest side at most kThumbnailSize pixels, the lens's distortion taken
/// out as it is from the matches. scripts/report reads it. Optional: scenes without it, and without some of the images,
/// are complete.
inline constexpr const char* kThumbnailsFile = "thumbnails.h5";
inline constexpr int kThumbnailSize = 640;

/// A small copy of an image, a JPEG file's bytes: reduced to kThumbnailSize, without the
/// distortion of its lens where the source knows the camera. Empty for a file that is no image.
std::string ThumbnailOf(const SourceImage& image);

/// The small copies of the images that the pairs name, as the file of a scene's folder, whole or not at all, on up to
/// `threads` threads (0: all cores). Those of files that are no images are left out. Throws Error.
void WriteThumbnailsOf(const ImageSource& source, const std::vector<Example>& pairs, int threads,
                       const std::string& folder);

}  // namespace diffsac
