#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/images/image_features.h"
#include "lab/images/image_format.h"
#include "lab/images/numpy_file.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "poses_bounds.npy";
constexpr std::size_t kNumbers = 17;  // a 3 × 5 matrix, row by row, and two depths

// [R | centre | height, width, focal length], R's columns down, right, backwards; the size that the focal length is for
// may be another than the file's.
SourceImage ReadImage(const std::string& path, const double* values, const std::string& place) {
  SourceImage image{ImageName(path), path, {}, {}};
  const double height = values[4], width = values[9], focal = values[14];
  if (!(height > 0.0) || !(width > 0.0) || !(focal > 0.0))
    throw Error(place + ": expected height, width, focal length");
  LensCamera camera;
  camera.size = ReadImageSize(path);
  camera.K << focal * camera.size.width / width, 0.0, 0.5 * camera.size.width - 0.5, 0.0,
      focal * camera.size.height / height, 0.5 * camera.size.height - 0.5, 0.0, 0.0, 1.0;
  image.camera = camera;
  std::vector<double> to_world;
  for (int row = 0; row < 3; ++row) {
    const double* r = values + 5 * row;
    to_world.insert(to_world.end(), {r[1], r[0], -r[2], r[3]});
  }
  image.pose = WorldToCamera(to_world, place);
  return image;
}

ImageSource ReadLlff(const PairsRequest& request) {
  const std::string file = (fs::path(request.input) / kFile).string();
  const NumpyArray poses = ReadNpy(file);
  if (poses.shape.size() != 2 || poses.shape[1] != kNumbers) throw Error(file + ": expected N rows of 17 numbers");
  const std::vector<std::string> paths = ListImages((fs::path(request.input) / "images").string());
  if (paths.size() != poses.shape[0])
    throw Error(file + ": " + std::to_string(poses.shape[0]) + " poses for " + std::to_string(paths.size()) +
                " images");
  ImageSource source;
  for (std::size_t i = 0; i < paths.size(); ++i)
    AddImage(
        ImageName(paths[i]),
        [&] { return ReadImage(paths[i], poses.values.data() + kNumbers * i, file + ": row " + std::to_string(i)); },
        &source);
  AddAllPairs(request.input, &source);
  return source;
}

const Registered<ImageFormat> kLlff("llff", {.read = ReadLlff});

}  // namespace
}  // namespace diffsac
