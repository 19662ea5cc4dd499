#include "lab/images/prepare_segments.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "diffsac/problem/coordinates.h"
#include "lab/images/detection.h"
#include "lab/images/exif_focal.h"
#include "lab/images/image_source.h"

namespace diffsac {

ImageSegments DetectSegments(const cv::Mat& gray, int max_image_size) {
  ImageSegments image;
  image.size = {gray.cols, gray.rows};
  const double scale =
      max_image_size > 0 ? std::max(1.0, double(std::max(gray.cols, gray.rows)) / max_image_size) : 1.0;
  cv::Mat reduced = gray;
  if (scale > 1.0) cv::resize(gray, reduced, {}, 1.0 / scale, 1.0 / scale, cv::INTER_AREA);
  std::vector<cv::Vec4f> found;
  cv::createLineSegmentDetector()->detect(reduced, found);
  std::stable_sort(found.begin(), found.end(), [](const cv::Vec4f& a, const cv::Vec4f& b) {
    return std::hypot(a[2] - a[0], a[3] - a[1]) > std::hypot(b[2] - b[0], b[3] - b[1]);
  });
  image.segments.resize(static_cast<Eigen::Index>(found.size()), 4);
  // Pixel centres have whole coordinates, in the file as in the reduced image.
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int k = 0; k < 4; ++k) image.segments(static_cast<Eigen::Index>(i), k) = scale * (found[i][k] + 0.5) - 0.5;
  return image;
}

Photograph ReadPhotograph(const std::string& path, const GivenCalibration& calibration) {
  const bool focal_alone = calibration.file.empty() && calibration.focal > 0.0 && calibration.center.empty();
  const std::optional<LensCamera> camera = focal_alone ? std::nullopt : CameraOf(calibration);
  Photograph photograph;
  photograph.gray = ReadGrayImage(path, camera ? Orientation::kAsStored : Orientation::kUpright);
  const ImageSize size{photograph.gray.cols, photograph.gray.rows};
  if (camera) {
    photograph.K = camera->K;
  } else if (focal_alone) {
    photograph.K = CentredCamera(calibration.focal, size);
  } else if (const auto focal = ExifFocalPx(path, size)) {
    photograph.K = CentredCamera(*focal, size);
    photograph.exif = true;
  }
  return photograph;
}

}  // namespace diffsac
