#include "lab/images/thumbnail.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "diffsac/core/parallel.h"
#include "lab/files/thumbnails.h"
#include "lab/images/detection.h"

namespace diffsac {
namespace {

constexpr int kQuality = 80;  // Of the JPEG.

// `scale`: pixels of the small image per pixel of the file.
cv::Mat WithoutDistortion(const cv::Mat& small, const LensCamera& camera, double scale) {
  cv::Mat from(small.size(), CV_32FC2);
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) {
      const Eigen::Vector2d pixel((x + 0.5) / scale - 0.5, (y + 0.5) / scale - 0.5), seen = camera.Distort(pixel);
      from.at<cv::Vec2f>(y, x) = {static_cast<float>((seen.x() + 0.5) * scale - 0.5),
                                  static_cast<float>((seen.y() + 0.5) * scale - 0.5)};
    }
  cv::Mat straight;
  cv::remap(small, straight, from, cv::noArray(), cv::INTER_LINEAR);
  return straight;
}

}  // namespace

std::string ThumbnailOf(const SourceImage& image) {
  // Matches are in the pixels of the file, whatever its orientation flag says.
  const int anything = cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION;
  cv::Mat picture = cv::imread(image.path, anything);
  if (picture.empty()) return "";
  // Of more than 8 bits it is scaled as it is for keypoints.
  if (picture.depth() != CV_8U) picture = ReadGrayImage(image.path);
  if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
  const double scale = std::min(1.0, static_cast<double>(kThumbnailSize) / std::max(picture.cols, picture.rows));
  if (scale < 1.0) cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  if (image.camera && !image.camera->IsStraight()) picture = WithoutDistortion(picture, *image.camera, scale);
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return {bytes.begin(), bytes.end()};
}

void WriteThumbnailsOf(const ImageSource& source, const std::vector<Example>& pairs, int threads,
                       const std::string& folder) {
  std::set<std::string> named;
  for (const Example& pair : pairs) named.insert({pair.image1, pair.image2});
  std::vector<std::string> names;
  std::vector<const SourceImage*> images;
  for (const SourceImage& image : source.images) {
    if (!named.contains(image.name)) continue;
    names.push_back(image.name);
    images.push_back(&image);
  }
  std::vector<std::string> bytes(images.size());
  ParallelFor(static_cast<std::int64_t>(images.size()), threads,
              [&](std::int64_t i) { bytes[i] = ThumbnailOf(*images[i]); });
  WriteThumbnails(folder, names, [&](std::size_t i) { return bytes[i]; });
}

}  // namespace diffsac
