#include "lab/report/pair_images.h"

#include <fnmatch.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "diffsac/core/logging.h"
#include "lab/files/thumbnails.h"

namespace diffsac {

std::pair<std::string, std::string> ImageNames(const Example& example) {
  if (!example.image1.empty()) return {example.image1, example.image2};
  const std::string pair = example.id.substr(example.id.rfind('/') + 1);
  const std::size_t dash = pair.find('-');
  if (dash == std::string::npos) return {};
  return {pair.substr(0, dash), pair.substr(dash + 1)};
}

ImageSize CanvasSize(const ImageSize& known, const PointMatrix& points, int column) {
  if (known.known()) return known;
  ImageSize size{1, 1};
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!points.row(i).allFinite()) continue;
    size.width = std::max(size.width, static_cast<int>(std::min(points(i, column), 1e5)) + 1);
    size.height = std::max(size.height, static_cast<int>(std::min(points(i, column + 1), 1e5)) + 1);
  }
  return size;
}

std::string ImageFile(const std::vector<ImageFolder>& folders, const std::string& scene, const std::string& image,
                      bool warn) {
  namespace fs = std::filesystem;
  for (const ImageFolder& folder : folders) {
    if (::fnmatch(folder.scenes.c_str(), scene.c_str(), 0) != 0) continue;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder.folder, error))
      if (entry.path().stem() == image && cv::haveImageReader(entry.path().string())) return entry.path().string();
    if (warn) LogWarning("no image '" + image + "' in " + folder.folder + ": its matches are drawn on an empty canvas");
  }
  return "";
}

cv::Mat LoadImageOf(const std::vector<ImageFolder>& folders, const std::string& scene, const std::string& scene_folder,
                    const std::string& image, const ImageSize& size, int longest) {
  const std::string file = ImageFile(folders, scene, image, false);
  if (!file.empty()) {
    // A JPEG of many megapixels is read several times faster at a part of its size.
    const int times = std::max(size.width, size.height) / std::max(1, longest);
    const int flags = times >= 4   ? cv::IMREAD_REDUCED_COLOR_4
                      : times >= 2 ? cv::IMREAD_REDUCED_COLOR_2
                                   : cv::IMREAD_COLOR;
    return cv::imread(file, flags | cv::IMREAD_IGNORE_ORIENTATION);
  }
  const std::string bytes = ReadThumbnail(scene_folder, image);
  if (bytes.empty()) return {};
  return cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_COLOR);
}

}  // namespace diffsac
