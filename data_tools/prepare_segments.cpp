#include "data_tools/prepare_segments.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "data_tools/detection.h"
#include "data_tools/exif_focal.h"
#include "data_tools/segment_benchmarks.h"
#include "diffsac/core/files.h"
#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "diffsac/lab/progress.h"
#include "diffsac/problem/coordinates.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

ImageSegments ReadPhotograph(const std::string& path, const SegmentsRequest& request) {
  ImageSegments image = DetectSegments(path, request.max_image_size);
  if (const auto camera = CameraOf(request.calibration)) {
    image.K = camera->K;
  } else if (const auto focal = ExifFocalPx(path, image.size)) {
    image.K = CentredCamera(*focal, image.size);
  }
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
      images[i] = ReadPhotograph(paths[i], request);
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

std::vector<SegmentScene> ReadScenes(const SegmentsRequest& request, const std::atomic<bool>& stop) {
  if (request.format == "nyu_vp") return ReadNyuVp(request.input);
  if (request.format == "yud_plus") return ReadYudPlus(request.input);
  const fs::path input(request.input);
  const std::string folder = fs::is_directory(input) ? request.input : input.parent_path().string();
  std::string name = request.scene.empty() ? FolderName(folder.empty() ? "." : folder) : request.scene;
  return {{std::move(name), ReadPhotographs(request, stop)}};
}

void Say(const SegmentScene& scene, const std::string& path) {
  std::size_t segments = 0, known = 0;
  for (const ImageSegments& image : scene.images) {
    segments += static_cast<std::size_t>(image.segments.rows());
    known += image.vanishing_points.size();
  }
  std::cout << path << ": " << scene.images.size() << " images, " << segments << " segments";
  if (known > 0) std::cout << ", " << known << " vanishing points";
  std::cout << std::endl;
}

}  // namespace

bool IsSegmentBenchmark(const std::string& format) {
  return std::find(std::begin(kSegmentBenchmarks), std::end(kSegmentBenchmarks), format) !=
         std::end(kSegmentBenchmarks);
}

ImageSegments DetectSegments(const std::string& path, int max_image_size) {
  cv::Mat gray = ReadGrayImage(path);
  ImageSegments image;
  image.name = ImageName(path);
  image.size = {gray.cols, gray.rows};
  const double scale =
      max_image_size > 0 ? std::max(1.0, double(std::max(gray.cols, gray.rows)) / max_image_size) : 1.0;
  if (scale > 1.0) cv::resize(gray, gray, {}, 1.0 / scale, 1.0 / scale, cv::INTER_AREA);
  std::vector<cv::Vec4f> found;
  cv::createLineSegmentDetector()->detect(gray, found);
  std::stable_sort(found.begin(), found.end(), [](const cv::Vec4f& a, const cv::Vec4f& b) {
    return std::hypot(a[2] - a[0], a[3] - a[1]) > std::hypot(b[2] - b[0], b[3] - b[1]);
  });
  image.segments.resize(static_cast<Eigen::Index>(found.size()), 4);
  // Pixel centres have whole coordinates, in the file as in the reduced image.
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int k = 0; k < 4; ++k) image.segments(static_cast<Eigen::Index>(i), k) = scale * (found[i][k] + 0.5) - 0.5;
  return image;
}

bool PrepareSegments(const SegmentsRequest& request, const std::atomic<bool>& stop) {
  if (!fs::exists(request.input)) throw Error("--input " + request.input + ": there is no such folder or file");
  for (const SegmentScene& scene : ReadScenes(request, stop)) {
    if (stop) return false;
    if (scene.images.empty()) throw Error(request.input + ": no image could be read");
    const std::string folder = (fs::path(request.output) / scene.name).string();
    const std::string path = (fs::path(folder) / kSegmentsFile).string();
    if (fs::exists(path) && !request.overwrite) {
      LogInfo(path + " is there already (--overwrite makes it again)");
      continue;
    }
    MakeWritableFolder(folder);
    WriteSegments(path, scene.images);
    Say(scene, path);
  }
  return true;
}

}  // namespace diffsac
