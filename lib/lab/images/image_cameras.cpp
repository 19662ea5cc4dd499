#include "lab/images/image_cameras.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/calibration.h"
#include "lab/colmap/model.h"
#include "lab/config/program.h"
#include "lab/config/report_script.h"
#include "lab/data/finite_points.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"
#include "lab/images/exif_focal.h"
#include "lab/images/image_features.h"
#include "lab/images/image_source.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

void CheckAlone(const GivenCalibration& given) {
  const bool others = given.focal != 0.0 || !given.center.empty() || !given.file.empty();
  if (!given.cameras.empty() && (others || !given.files.empty()))
    throw Error("--cameras excludes --calibration, --focal and --center");
  if (!given.files.empty() && others) throw Error("--calibration excludes --focal and --center");
}

// Whether a path ends in this relative one, folder by folder.
bool EndsIn(const fs::path& path, const fs::path& end) {
  const auto parts = std::distance(path.begin(), path.end()), last = std::distance(end.begin(), end.end());
  return parts >= last && std::equal(end.begin(), end.end(), std::next(path.begin(), parts - last));
}

std::string PixelsText(double x, double y) { return "(" + PlainNumber(x) + ", " + PlainNumber(y) + ")"; }

/// Of a matrix, or a focal length, that does not say what size of images it is for; `name`: what gave it.
void CheckFits(const Eigen::Matrix3d& K, const ImageSize& size, const std::string& name) {
  // Nine tenths of 180 degrees take .08; wide lenses without distortion see 130, with a focal length of .23.
  constexpr double kLeastFocal = 0.12, kMostAside = 0.1;
  const double longer = std::max(size.width, size.height), focal = std::max(K(0, 0), K(1, 1));
  if (!size.known()) return;
  if (focal < kLeastFocal * longer)
    throw Error(name + ": a focal length of " + PlainNumber(focal) + " pixels would see " +
                PlainNumber(std::round(2.0 * std::atan(0.5 * longer / focal) * 180.0 / M_PI)) + " degrees of " +
                SizeText(size) +
                ": it is in another unit (pixels = millimetres / sensor's width * image's width), or " +
                "of another size");
  const double x = (K(0, 2) + 0.5) / size.width, y = (K(1, 2) + 0.5) / size.height;
  if (std::max(std::abs(x - 0.5), std::abs(y - 0.5)) > kMostAside)
    WarnOnce(name + ": the principal point " + PixelsText(K(0, 2), K(1, 2)) + " is far from the middle of " +
             SizeText(size) + ": unless the image was cropped, the calibration is of another size" +
             (std::abs(x - y) > 0.05 * x || x < 0.05
                  ? std::string()
                  : ", " +
                        SizeText({static_cast<int>(std::lround(2.0 * x * size.width)),
                                  static_cast<int>(std::lround(2.0 * y * size.height))}) +
                        ", say"));
}

}  // namespace

ImageCameras::ImageCameras(const GivenCalibration& calibration, const std::vector<std::string>& paths)
    : given_(calibration), paths_(paths), cameras_(paths.size()) {
  CheckAlone(given_);
  if (!given_.cameras.empty()) {
    ReadColmap();
    return;
  }
  if (given_.files.empty()) {
    // A focal length alone waits for the image's size.
    if (given_.focal > 0.0 && given_.center.empty() && given_.file.empty()) return;
    std::fill(cameras_.begin(), cameras_.end(), CameraOf(given_));
    return;
  }
  if (given_.files.size() != paths.size())
    throw Error("--calibration: expected one file, or one for each of the " + std::to_string(paths.size()) +
                " images, found " + std::to_string(given_.files.size()));
  for (std::size_t i = 0; i < paths.size(); ++i) cameras_[i] = CameraOf({given_.files[i], 0.0, {}});
}

void ImageCameras::ReadColmap() {
  const fs::path path = given_.cameras;
  std::error_code code;
  if (!fs::is_directory(path, code) &&
      FindColmapModel(path.parent_path().string(), path.extension().string()).empty()) {
    const auto cameras = ReadColmapCameras(path.string());
    if (cameras.size() != 1)
      throw Error(path.string() + ": expected one camera, or images" + path.extension().string() +
                  " beside it, which says whose they are; found " + std::to_string(cameras.size()));
    std::fill(cameras_.begin(), cameras_.end(), cameras.begin()->second);
    return;
  }
  const fs::path model = fs::is_directory(path, code) ? path : path.parent_path();
  const ImageSource source = ReadColmapImages(model.string(), "");
  if (source.images.empty() && !source.left_out.empty()) throw Error(source.left_out.front().problem);
  for (const LeftOutImage& image : source.left_out) {
    WarnOnce("left out: " + image.problem);
    left_out_[image.name] = image.problem;
  }
  for (const SourceImage& image : source.images)
    for (std::size_t i = 0; i < paths_.size(); ++i)
      if (EndsIn(paths_[i], image.path)) cameras_[i] = image.camera;
}

std::string ImageCameras::NameOf(std::size_t image) const {
  if (!given_.files.empty()) return given_.files.at(image);
  return given_.file.empty() ? "--focal" : given_.file;
}

std::optional<LensCamera> ImageCameras::Of(std::size_t image, const ImageSize& size) const {
  std::optional<LensCamera> camera = cameras_.at(image);
  if (!camera && given_.focal > 0.0)
    camera = CameraOf({"", given_.focal, {0.5 * (size.width - 1), 0.5 * (size.height - 1)}});
  const auto left_out = left_out_.find(ImageName(paths_[image]));
  if (!camera && left_out != left_out_.end()) throw Error(paths_[image] + ": " + left_out->second);
  if (!camera && !given_.cameras.empty()) throw Error(paths_[image] + ": " + given_.cameras + " has no such image");
  if (camera && given_.cameras.empty()) CheckFits(camera->K, size, NameOf(image));
  if (camera && camera->size.known() && !(camera->size == size))
    throw Error(paths_[image] + ": is " + SizeText(size) + ", but its camera is for " + SizeText(camera->size));
  return camera;
}

void ImageCameras::WarnOfSizes(const std::vector<ImageSize>& sizes) const {
  const bool shared = !given_.file.empty() || !given_.center.empty();
  if (!shared && !(given_.focal > 0.0)) return;
  // A focal length alone is that of the image turned by a quarter as well.
  const auto sides = [&](const ImageSize& size) {
    return shared ? std::pair(size.width, size.height) : std::pair<int, int>(std::minmax(size.width, size.height));
  };
  const auto found = std::find_if(sizes.begin(), sizes.end(),
                                  [&](const ImageSize& size) { return sides(size) != sides(sizes.front()); });
  if (found == sizes.end()) return;
  LogWarning(std::string(shared ? "one calibration" : "one --focal, in pixels,") + " for images of " +
             SizeText(sizes.front()) + " and " + SizeText(*found) +
             " pixels: --calibration K1.txt,K2.txt gives each its own" +
             (shared ? ", and --focal alone takes each image's middle" : ""));
}

CameraPriorHint ExifHint(const std::string& path, const ImageSize& size) {
  CameraPriorHint hint;
  if (const auto focal = ExifFocalPx(path, size)) hint.focal = FocalPrior{*focal, kExifLogSigma};
  return hint;
}

void AddCalibrationOptions(CLI::App* app, GivenCalibration* calibration) {
  app->add_option_function<std::vector<std::string>>(
         "--calibration",
         [calibration](const std::vector<std::string>& files) {
           if (files.size() == 1)
             calibration->file = files[0];
           else
             calibration->files = files;
         },
         "A file with the 3x3 matrix K of all images, or one for each, as a.txt,b.txt: nine numbers, .npy or JSON "
         "(default: none; the focal length is looked for in EXIF data)")
      ->delimiter(',')
      ->allow_extra_args(false);
  app->add_option("--cameras", calibration->cameras,
                  "COLMAP's cameras of the images: the folder of a model, or a file cameras.txt; any camera model, and "
                  "its distortion is taken out (default: none)");
  app->add_option("--focal", calibration->focal, "Focal length of all images, in pixels (default: unknown)")
      ->check(NumberAbove(0));
  app->add_option("--center", calibration->center, "Principal point, as 320,240 (default: each image's middle)")
      ->delimiter(',');
}

namespace {

using Json = nlohmann::json;

// The numbers of arrays in arrays, in their order.
void AddNumbers(const Json& json, std::vector<double>* numbers) {
  if (json.is_number()) numbers->push_back(json.get<double>());
  if (json.is_array())
    for (const Json& item : json) AddNumbers(item, numbers);
}

/// Of an object; `data` is OpenCV's and ROS's name of a matrix's numbers.
Eigen::Matrix3d MatrixFromJson(const Json& json, const std::string& path) {
  if (json.contains("fx") && json.contains("fy") && json.contains("cx") && json.contains("cy")) {
    std::vector<double> f;
    for (const char* key : {"fx", "fy", "cx", "cy"}) AddNumbers(json[key], &f);
    if (f.size() == 4) return Eigen::Matrix3d{{f[0], 0.0, f[2]}, {0.0, f[1], f[3]}, {0.0, 0.0, 1.0}};
  }
  std::vector<double> numbers;
  for (const char* key : {"K", "k", "camera_matrix"})
    if (json.contains(key) && numbers.empty())
      AddNumbers(json[key].is_object() ? json[key].value("data", Json()) : json[key], &numbers);
  if (numbers.size() != 9) throw Error(path + ": expected a 3x3 matrix at K or camera_matrix, or fx, fy, cx and cy");
  return MatrixFromRows(numbers.data());
}

Eigen::Matrix3d MatrixOf(const std::string& path) {
  Eigen::Matrix3d matrix;
  if (std::filesystem::path(path).extension() == ".npy") {
    ReadConverted("matrix", path, [&](const std::string& text) { matrix = ReadMatrixFile(text); });
    return matrix;
  }
  const std::string text = ReadTextFile(path);
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string::npos || text[start] != '{') return ReadMatrixFile(path);
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) throw Error(path + ": no JSON that can be read");
  return MatrixFromJson(json, path);
}

}  // namespace

Eigen::Matrix3d ReadCalibrationMatrix(const std::string& path) { return CheckedCalibration(MatrixOf(path), path); }

}  // namespace diffsac
