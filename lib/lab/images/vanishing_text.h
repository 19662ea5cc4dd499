#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/diffsac.h"
#include "lab/files/segment_files.h"
#include "lab/images/image_source.h"

namespace diffsac {

/// A photograph and its vanishing points.
struct VanishingImage {
  ImageSegments image;  ///< K: that was given, or EXIF's.
  bool exif = false;    ///< It is EXIF's.
  VanishingPointsEstimate estimate;
  double ms_segments = 0.0;  ///< Milliseconds of finding them.
};

/// Where a vanishing point is in the image: "(1200.5, 300.0)", or "at infinity along (0.00, 1.00)".
std::string PlaceText(const Eigen::Vector3d& point, const ImageSize& size);

/// Segments of each vanishing point, in their order.
std::vector<int> SegmentCounts(const VanishingPointsEstimate& estimate);

/// For a terminal: the vanishing points, focal length, horizon, milliseconds. Without vanishing points, why.
std::string VanishingText(const VanishingImage& found);

/// A line for each segment: x1 y1 x2 y2, with all digits, and the number of its vanishing point, 0 for none.
std::string SegmentsText(const VanishingImage& found);

/// One JSON object, `images`, with everything.
std::string VanishingJson(const std::vector<VanishingImage>& images);

/// The segments that the detector finds in a grey image, in its pixels, longest first; larger images are reduced to
/// this longer side before, 0: never.
ImageSegments DetectSegments(const cv::Mat& gray, int max_image_size);

/// A photograph whose segments are looked for.
struct Photograph {
  cv::Mat gray;
  /// As given, which is of the image as it is stored, or else EXIF's focal length about the middle; nothing where there
  /// is neither. A focal length that is given without a principal point is about the middle, too.
  std::optional<Eigen::Matrix3d> K;
  bool exif = false;  ///< K is by EXIF's focal length.
};

/// Without a calibration the image is upright (Orientation::kUpright). Throws Error naming the file.
Photograph ReadPhotograph(const std::string& path, const GivenCalibration& calibration);

}  // namespace diffsac
