#pragma once

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <string>
#include <vector>

#include "lab/images/image_features.h"

namespace diffsac {

/// An image, reduced where that was asked for, with its keypoints as OpenCV gives them.
struct Detection {
  FeatureKind kind = FeatureKind::kRootSift;
  cv::Mat image;
  ImageSize size;      ///< Of the file.
  double scale = 1.0;  ///< Pixels of the file in one of `image`.
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat raw;  ///< Their descriptors.

  /// Where keypoint i is in the file's pixels.
  Eigen::RowVector2d Position(std::size_t i) const;
  /// The logarithm of its diameter in the file's pixels; its angle in radians, from the x axis towards the y axis.
  Eigen::RowVector2d Frame(std::size_t i) const;
};

/// Throws Error naming the path where there is no file, or one that does not begin as an image does. Takes no time.
void RequireImage(const std::string& path);

/// Which way up an image is read.
enum class Orientation {
  kAsStored,  ///< What calibrations refer to: the orientation flag of its EXIF data is ignored.
  kUpright,   ///< As viewers show it, by that flag.
};

/// The grey values of a file, in 8 bits. Of 16 bits the range that is used counts, to the next power of two; numbers
/// with a floating point in [0, 1] and [0, 255] are light, others go from the least to the greatest. Throws Error
/// naming the file.
cv::Mat ReadGrayImage(const std::string& path, Orientation orientation = Orientation::kAsStored);
cv::Ptr<cv::Feature2D> MakeDetector(const FeatureOptions& options);
Detection Detect(const std::string& path, const FeatureOptions& options);
/// One row of descriptors to bytes: as they are, where so many bytes are a row; else numbers to bytes. OpenCV rounds
/// SIFT's values to whole numbers up to 255, whatever it stores them in.
void CopyBytes(const cv::Mat& raw, int from, Eigen::Index to, ByteMatrix* bytes);

}  // namespace diffsac
