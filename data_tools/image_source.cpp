#include "data_tools/image_source.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "data_tools/number_file.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace fs = std::filesystem;

std::vector<std::string> ListImages(const std::string& folder) {
  static const std::set<std::string> kExtensions = {".png", ".jpg", ".jpeg", ".ppm", ".pgm", ".tif", ".tiff", ".bmp"};
  std::error_code code;
  if (!fs::is_directory(folder, code)) throw Error(folder + ": no such folder");
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    if (kExtensions.count(extension) > 0) paths.push_back(entry.path().string());
  }
  if (paths.empty()) throw Error(folder + ": no images in this folder");
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string ImageName(const std::string& path) {
  std::string name = fs::path(path).stem().string();
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::vector<SourcePair> AllPairs(int num_images) {
  std::vector<SourcePair> pairs;
  for (int i = 0; i < num_images; ++i)
    for (int j = i + 1; j < num_images; ++j) pairs.push_back({i, j, {}});
  return pairs;
}

std::string FolderName(const std::string& folder) {
  std::error_code code;
  const fs::path whole = fs::weakly_canonical(folder, code);
  return (code ? fs::path(folder) : whole).filename().string();
}

void CheckSource(const ImageSource& source, const std::string& folder) {
  std::set<std::string> names;
  for (const SourceImage& image : source.images)
    if (!names.insert(image.name).second) throw Error(folder + ": two images are named " + image.name);
  for (const SourceScene& scene : source.scenes)
    if (scene.pairs.empty()) throw Error(folder + ": no pairs of images for " + scene.name);
}

ImageSource ReadImageFolder(const std::string& folder, const std::string& calibration) {
  ImageSource source;
  std::optional<LensCamera> camera;
  if (!calibration.empty()) {
    camera.emplace();
    camera->K = ReadMatrixFile(calibration);
    if (!camera->K.allFinite() || camera->K(0, 0) <= 0.0 || camera->K(1, 1) <= 0.0 ||
        camera->K.row(2) != Eigen::RowVector3d(0, 0, 1))
      throw Error(calibration + ": not a calibration matrix (positive focal lengths, last row 0 0 1)");
  }
  for (const std::string& path : ListImages(folder)) source.images.push_back({ImageName(path), path, camera, {}});
  source.scenes.push_back({FolderName(folder), AllPairs(static_cast<int>(source.images.size()))});
  CheckSource(source, folder);
  return source;
}

}  // namespace diffsac
