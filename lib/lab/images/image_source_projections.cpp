#include <Eigen/LU>
#include <filesystem>
#include <opencv2/calib3d.hpp>

#include "diffsac/core/status.h"
#include "lab/images/image_format.h"
#include "lab/images/numpy_file.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFile = "cameras.npz";

// K and [R | t] of a projection matrix, the upper three rows of `values`, 4 × 4.
SourceImage ReadImage(const std::string& path, const NumpyArray& matrix, const std::string& place) {
  if (matrix.shape != std::vector<std::size_t>{4, 4}) throw Error(place + ": expected a 4x4 matrix");
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> P(matrix.values.data());
  if (!P.allFinite() || P.leftCols<3>().determinant() == 0.0) throw Error(place + ": expected a projection matrix");
  // Its sign is free; the scene is before the camera where the left part has a positive determinant.
  const double sign = P.leftCols<3>().determinant() < 0.0 ? -1.0 : 1.0;
  cv::Mat projection(3, 4, CV_64F), K, R, centre;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) projection.at<double>(i, j) = sign * P(i, j);
  cv::decomposeProjectionMatrix(projection, K, R, centre);
  RigidMotion to_world;
  SourceImage image{ImageName(path), path, {}, {}};
  LensCamera camera;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      camera.K(i, j) = K.at<double>(i, j) / K.at<double>(2, 2);
      to_world.rotation(i, j) = R.at<double>(j, i);
    }
    to_world.translation[i] = centre.at<double>(i) / centre.at<double>(3);
  }
  image.camera = camera;
  image.pose = Inverse(SoundMotion(to_world, place));
  return image;
}

ImageSource ReadProjections(const PairsRequest& request) {
  const std::string file = (fs::path(request.input) / kFile).string();
  const auto arrays = ReadNpz(file);
  const fs::path folder =
      fs::path(request.input) / (fs::exists(fs::path(request.input) / "image") ? "image" : "images");
  const std::vector<std::string> paths = ListImages(folder.string());
  ImageSource source;
  for (std::size_t i = 0; i < paths.size(); ++i)
    AddImage(
        ImageName(paths[i]),
        [&] {
          const std::string key = "world_mat_" + std::to_string(i);
          const auto found = arrays.find(key);
          if (found == arrays.end()) throw Error(file + ": there is no " + key);
          return ReadImage(paths[i], found->second, file + ": " + key);
        },
        &source);
  AddAllPairs(request.input, &source);
  return source;
}

const Registered<ImageFormat> kProjections("projections", {.read = ReadProjections});

}  // namespace
}  // namespace diffsac
