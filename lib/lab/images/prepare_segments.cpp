#include "lab/images/prepare_segments.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/coordinates.h"
#include "lab/config/progress.h"
#include "lab/files/files.h"
#include "lab/images/detection.h"
#include "lab/images/exif_focal.h"
#include "lab/images/image_source.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

ImageSegments SegmentsOf(const std::string& path, const SegmentsRequest& request) {
  const Photograph photograph = ReadPhotograph(path, request.calibration);
  ImageSegments image = DetectSegments(photograph.gray, request.max_image_size);
  image.name = ImageName(path);
  image.K = photograph.K;
  return image;
}

std::vector<ImageSegments> ReadPhotographs(const SegmentsRequest& request, const std::atomic<bool>& stop) {
  const std::vector<std::string> paths =
      fs::is_directory(request.input) ? ListImages(request.input) : std::vector<std::string>{request.input};
  std::vector<ImageSegments> images(paths.size());
  std::vector<std::string> problems(paths.size());
  Progress progress("images", static_cast<std::int64_t>(paths.size()));
  ParallelFor(static_cast<std::int64_t>(paths.size()), request.threads, [&](std::int64_t i) {
    if (stop) return;
    try {
      images[i] = SegmentsOf(paths[i], request);
    } catch (const Error& error) {
      problems[i] = error.what();
    }
    progress.Advance();
  });
  progress.Finish();
  std::vector<ImageSegments> good;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (problems[i].empty())
      good.push_back(std::move(images[i]));
    else
      LogWarning("left out: " + problems[i]);
  }
  return good;
}

std::string SceneOfPhotographs(const SegmentsRequest& request) {
  if (!request.scene.empty()) return request.scene;
  const fs::path input(request.input);
  const std::string folder = fs::is_directory(input) ? request.input : input.parent_path().string();
  return FolderName(folder.empty() ? "." : folder);
}

}  // namespace

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

bool PrepareSegments(const SegmentsRequest& request, const std::atomic<bool>& stop) {
  if (!fs::exists(request.input)) throw Error("--input " + request.input + ": there is no such folder or file");
  const std::string name = SceneOfPhotographs(request);
  const std::string path = (fs::path(request.output) / name / kSegmentsFile).string();
  if (!request.overwrite && fs::exists(path)) {
    LogInfo(path + " is there already (--overwrite makes it again)");
    return true;
  }
  const std::vector<ImageSegments> images = ReadPhotographs(request, stop);
  if (stop) return false;
  if (images.empty()) throw Error(request.input + ": no image could be read");
  MakeWritableFolder(fs::path(path).parent_path().string());
  WriteSegments(path, images);
  std::size_t segments = 0;
  for (const ImageSegments& image : images) segments += static_cast<std::size_t>(image.segments.rows());
  std::cout << path << ": " << images.size() << " images, " << segments << " segments" << std::endl;
  return true;
}

}  // namespace diffsac
