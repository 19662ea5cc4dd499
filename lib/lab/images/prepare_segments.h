#pragma once

#include <atomic>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "lab/files/segment_files.h"
#include "lab/images/image_source.h"

namespace diffsac {

/// The command `diffsac_prepare segments`: line segments of photographs in a folder, or of one, as SCENE/segments.h5
/// (lab/files/segment_files.h), by OpenCV's detector (von Gioi et al., "LSD", PAMI 2010).
struct SegmentsRequest {
  std::string input, output;
  std::string scene;             ///< The scene's name; empty: the folder's.
  GivenCalibration calibration;  ///< Of all of them; not given: EXIF's focal length, if there is one.
  int max_image_size = 0;        ///< Larger ones are reduced to this longer side; 0: never.
  bool overwrite = false;
  int threads = 0;
};

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

/// Prints a line a scene. A file that is there already stays, before anything is detected. False when it was stopped.
/// Throws Error.
bool PrepareSegments(const SegmentsRequest& request, const std::atomic<bool>& stop);

}  // namespace diffsac
