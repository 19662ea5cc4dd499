#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "lab/files/segment_files.h"
#include "lab/images/image_source.h"

namespace diffsac {

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
