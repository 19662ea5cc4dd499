#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/images/image_format.h"
#include "lab/images/image_source.h"
#include "lab/images/number_file.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// K (9), distortion (3, zeros), the camera-to-world rotation (9), the centre (3), width and height.
constexpr std::size_t kNumbers = 26;

void ReadCamera(const std::string& path, SourceImage* image) {
  std::vector<double> values;
  for (const NumberLine& line : ReadNumberFile(path))
    values.insert(values.end(), line.values.begin(), line.values.end());
  if (values.size() != kNumbers)
    throw Error(path + ": expected " + std::to_string(kNumbers) + " numbers, found " + std::to_string(values.size()));
  if (values[9] != 0.0 || values[10] != 0.0 || values[11] != 0.0)
    throw Error(path + ": expected an undistorted image (three zeros after K)");
  LensCamera camera;
  camera.K = MatrixFromRows(values.data());
  camera.size = {PixelCount(values[24], path), PixelCount(values[25], path)};
  image->camera = camera;
  std::vector<double> to_world;
  for (int row = 0; row < 3; ++row) {
    to_world.insert(to_world.end(), values.begin() + 12 + 3 * row, values.begin() + 15 + 3 * row);
    to_world.push_back(values[21 + row]);
  }
  image->pose = WorldToCamera(to_world, path);
}

}  // namespace

ImageSource ReadStrecha(const std::string& folder) {
  ImageSource source;
  for (const std::string& path : ListImages((fs::path(folder) / "images").string())) {
    const auto read = [&] {
      SourceImage image{ImageName(path), path, {}, {}};
      const std::string file = fs::path(path).filename().string() + ".camera";
      ReadCamera((fs::path(folder) / "gt_dense_cameras" / file).string(), &image);
      return image;
    };
    AddImage(ImageName(path), read, &source);
  }
  AddAllPairs(folder, &source);
  return source;
}

namespace {

const Registered<ImageFormat> kStrecha("strecha", {.read = [](const PairsRequest& request) {
                                         return ReadStrecha(request.input);
                                       }});

}  // namespace

}  // namespace diffsac
