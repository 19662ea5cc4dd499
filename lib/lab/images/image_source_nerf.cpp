#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "lab/images/image_features.h"
#include "lab/images/image_format.h"
#include "lab/images/image_source.h"
#include "lab/images/number_file.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kSmallestAngle = 1e-6;  // A camera_angle_x; below it focal lengths are infinite.

Json ReadJson(const std::string& path) {
  try {
    return Json::parse(ReadTextFile(path));
  } catch (const Json::exception& error) {
    throw Error(path + ": not JSON: " + error.what());
  }
}

// The calibration of a frame, whose own values go before those of all frames.
class CameraReader {
 public:
  CameraReader(const Json& all, const Json& frame, const std::string& place)
      : all_(all), frame_(frame), place_(place) {}

  LensCamera Read() const {
    CheckModel();
    LensCamera camera;
    camera.size = {PixelCount(Number("w", 0.0), place_), PixelCount(Number("h", 0.0), place_)};
    const double fx = Has("fl_x") ? Number("fl_x") : FocalFromAngle(camera.size);
    const double fy = Number("fl_y", fx);
    if (!(fx > 0.0) || !(fy > 0.0)) throw Error(place_ + ": expected positive focal lengths (fl_x, fl_y)");
    if (!Has("cx") && camera.size.width == 0) throw Error(place_ + ": neither cx nor w is given");
    if (!Has("cy") && camera.size.height == 0) throw Error(place_ + ": neither cy nor h is given");
    // From COLMAP's pixels, whose first centre is (0.5, 0.5).
    const double cx = Number("cx", camera.size.width / 2.0) - 0.5, cy = Number("cy", camera.size.height / 2.0) - 0.5;
    camera.K << fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0;
    camera.k1 = Number("k1", 0.0);
    camera.k2 = Number("k2", 0.0);
    camera.p1 = Number("p1", 0.0);
    camera.p2 = Number("p2", 0.0);
    return camera;
  }

 private:
  const Json* Find(const char* key) const {
    for (const Json* values : {&frame_, &all_})
      if (const auto found = values->find(key); found != values->end()) return &*found;
    return nullptr;
  }

  bool Has(const char* key) const { return Find(key) != nullptr; }

  double Number(const char* key) const {
    const Json* value = Find(key);
    if (!value->is_number()) throw Error(place_ + ": expected a number as " + key);
    return value->get<double>();
  }
  double Number(const char* key, double other) const { return Has(key) ? Number(key) : other; }

  double FocalFromAngle(const ImageSize& size) const {
    if (!Has("camera_angle_x") || size.width == 0) throw Error(place_ + ": expected fl_x, or camera_angle_x and w");
    const double angle = Number("camera_angle_x");
    if (!(angle > kSmallestAngle) || !(angle < std::numbers::pi))
      throw Error(place_ + ": expected camera_angle_x between 0 and pi");
    return 0.5 * size.width / std::tan(0.5 * angle);
  }

  void CheckModel() const {
    for (const char* key : {"k3", "k4"})
      if (Number(key, 0.0) != 0.0) throw Error(place_ + ": lens distortion with " + key + " is not supported");
    const Json* fisheye = Find("is_fisheye");
    const Json* model = Find("camera_model");
    if ((fisheye && fisheye->is_boolean() && fisheye->get<bool>()) ||
        (model && model->is_string() && model->get<std::string>().find("FISHEYE") != std::string::npos))
      throw Error(place_ + ": fisheye cameras are not supported");
  }

  const Json& all_;
  const Json& frame_;
  std::string place_;
};

RigidMotion ReadTransform(const Json& frame, const std::string& place) {
  const auto found = frame.find("transform_matrix");
  std::vector<double> values;
  if (found != frame.end() && found->is_array())
    for (const Json& row : *found)
      if (row.is_array() && row.size() == 4)
        for (const Json& value : row)
          if (value.is_number()) values.push_back(value.get<double>());
  if (values.size() != 12 && values.size() != 16) throw Error(place + ": expected transform_matrix, a 4x4 matrix");
  // From OpenGL's axes (y up, z backwards) to y down, z forwards.
  for (std::size_t row = 0; row < 3; ++row) {
    values[4 * row + 1] = -values[4 * row + 1];
    values[4 * row + 2] = -values[4 * row + 2];
  }
  return WorldToCamera(values, place);
}

// Some files name images without their extension, or in a folder that was left out when they were published.
std::string ImagePath(const fs::path& folder, const std::string& file) {
  const fs::path path = (folder / file).lexically_normal();
  std::error_code code;
  for (const fs::path& candidate : {path, folder / path.filename()})
    for (const char* extension : {"", ".png", ".jpg", ".jpeg"})
      if (fs::exists(candidate.string() + extension, code)) return candidate.string() + extension;
  throw Error(path.string() + ": no such file");
}

// Some images were reduced after their calibration: of the same shape, but for what rounding did to it.
void FitTo(const ImageSize& size, LensCamera* camera) {
  const double w = camera->size.width, h = camera->size.height;
  if (w == 0.0 || h == 0.0 || std::abs(w * size.height - h * size.width) > std::max(w, h)) return;
  const double x = size.width / w, y = size.height / h;
  camera->K.row(0) *= x;
  camera->K.row(1) *= y;
  // The first pixel's centre moves: COLMAP's pixels begin at its corner.
  camera->K(0, 2) += 0.5 * (x - 1.0);
  camera->K(1, 2) += 0.5 * (y - 1.0);
  camera->size = size;
}

std::string FilePathOf(const Json& frame) {
  if (!frame.is_object()) return "";
  const auto found = frame.find("file_path");
  if (found == frame.end() || !found->is_string()) return "";
  std::string file = found->get<std::string>();
  // Files written under Windows.
  std::replace(file.begin(), file.end(), '\\', '/');
  // "./images/0001" is "images/0001".
  return fs::path(file).lexically_normal().string();
}

// Frames in the order of their files, which is that of the recording where the list is not.
std::vector<Json> SortedFrames(const Json& all, const std::string& path) {
  const auto found = all.is_object() ? all.find("frames") : all.end();
  if (found == all.end() || !found->is_array()) throw Error(path + ": expected an object with a list of frames");
  std::vector<Json> frames(found->begin(), found->end());
  std::stable_sort(frames.begin(), frames.end(),
                   [](const Json& a, const Json& b) { return FilePathOf(a) < FilePathOf(b); });
  return frames;
}

}  // namespace

ImageSource ReadNerf(const std::string& folder) {
  std::error_code code;
  const fs::path json = fs::is_regular_file(folder, code) ? fs::path(folder) : fs::path(folder) / "transforms.json";
  const Json all = ReadJson(json.string());
  ImageSource source;
  for (const Json& frame : SortedFrames(all, json.string())) {
    const std::string file = FilePathOf(frame);
    const std::string place = json.string() + ": " + (file.empty() ? "a frame" : file);
    const auto read = [&] {
      if (file.empty()) throw Error(place + ": expected file_path");
      const std::string path = ImagePath(json.parent_path(), file);
      LensCamera camera = CameraReader(all, frame, place).Read();
      FitTo(ReadImageSize(path), &camera);
      return SourceImage{ImageName(path), path, camera, ReadTransform(frame, place)};
    };
    AddImage(ImageName(file), read, &source);
  }
  const std::string name = FolderName(json.has_parent_path() ? json.parent_path().string() : ".");
  source.scenes.push_back({name, AllPairs(static_cast<int>(source.images.size()))});
  CheckSource(source, json.string());
  return source;
}

namespace {

const Registered<ImageFormat> kNerf("nerf",
                                    {.read = [](const PairsRequest& request) { return ReadNerf(request.input); }});

}  // namespace

}  // namespace diffsac
