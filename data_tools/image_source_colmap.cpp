#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>

#include "data_tools/colmap_text.h"
#include "data_tools/image_format.h"
#include "data_tools/image_source.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// Which parameters a camera model has, by name.
const std::map<std::string, std::vector<std::string>>& CameraModels() {
  static const std::map<std::string, std::vector<std::string>> models = {
      {"SIMPLE_PINHOLE", {"f", "cx", "cy"}},
      {"PINHOLE", {"fx", "fy", "cx", "cy"}},
      {"SIMPLE_RADIAL", {"f", "cx", "cy", "k1"}},
      {"RADIAL", {"f", "cx", "cy", "k1", "k2"}},
      {"OPENCV", {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"}}};
  return models;
}

LensCamera CameraFrom(const std::map<std::string, double>& p, const ImageSize& size) {
  const auto get = [&](const char* name, const char* other = "") {
    const auto found = p.count(name) > 0 ? p.find(name) : p.find(other);
    return found == p.end() ? 0.0 : found->second;
  };
  LensCamera camera;
  // From COLMAP's pixels, whose first centre is (0.5, 0.5).
  camera.K << get("fx", "f"), 0.0, get("cx") - 0.5, 0.0, get("fy", "f"), get("cy") - 0.5, 0.0, 0.0, 1.0;
  camera.k1 = get("k1");
  camera.k2 = get("k2");
  camera.p1 = get("p1");
  camera.p2 = get("p2");
  camera.size = size;
  return camera;
}

// CAMERA_ID MODEL WIDTH HEIGHT PARAMS...
std::map<std::string, LensCamera> ReadCameras(const std::string& path) {
  std::map<std::string, LensCamera> cameras;
  ColmapLines reader(path);
  while (reader.Next()) {
    const auto words = reader.Words();
    if (words.empty()) continue;
    if (words.size() < 4) reader.Fail("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
    const auto model = CameraModels().find(std::string(words[1]));
    if (model == CameraModels().end()) reader.Fail("the camera model " + std::string(words[1]) + " is not supported");
    const auto& names = model->second;
    if (words.size() != 4 + names.size()) reader.Fail("expected " + std::to_string(names.size()) + " parameters");
    std::map<std::string, double> parameters;
    for (std::size_t i = 0; i < names.size(); ++i) parameters[names[i]] = reader.Number(words[4 + i]);
    const ImageSize size = {static_cast<int>(reader.Number(words[2])), static_cast<int>(reader.Number(words[3]))};
    cameras[std::string(words[0])] = CameraFrom(parameters, size);
  }
  return cameras;
}

// IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, each followed by a line of points, which may be empty.
std::vector<SourceImage> ReadImages(const std::string& path, const std::string& images,
                                    const std::map<std::string, LensCamera>& cameras) {
  std::vector<SourceImage> result;
  ColmapLines reader(path);
  while (reader.Next()) {
    const auto words = reader.Words();
    if (words.empty()) continue;
    if (words.size() != 10) reader.Fail("expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    double v[7];
    for (int i = 0; i < 7; ++i) v[i] = reader.Number(words[1 + i]);
    const Eigen::Quaterniond quaternion(v[0], v[1], v[2], v[3]);
    if (!(quaternion.norm() > 0.0)) reader.Fail("expected a rotation");
    const auto camera = cameras.find(std::string(words[8]));
    if (camera == cameras.end()) reader.Fail("cameras.txt has no camera " + std::string(words[8]));
    RigidMotion pose;
    pose.rotation = quaternion.normalized().toRotationMatrix();
    pose.translation << v[4], v[5], v[6];
    const std::string file = (fs::path(images) / std::string(words[9])).string();
    result.push_back({ImageName(file), file, camera->second, pose});
    reader.Next();
  }
  return result;
}

}  // namespace

ImageSource ReadColmap(const std::string& folder) {
  const std::string model = ColmapModelFolder(folder);
  ImageSource source;
  source.images = ReadImages((fs::path(model) / "images.txt").string(), (fs::path(folder) / "images").string(),
                             ReadCameras((fs::path(model) / "cameras.txt").string()));
  std::sort(source.images.begin(), source.images.end(),
            [](const SourceImage& a, const SourceImage& b) { return a.name < b.name; });
  for (std::size_t i = 0; i < source.images.size(); ++i) source.images[i].frame = static_cast<int>(i);
  AddAllPairs(folder, &source);
  return source;
}

namespace {

const Registered<ImageFormat> kColmap("colmap",
                                      {.read = [](const PairsRequest& request) { return ReadColmap(request.input); }});

}  // namespace

}  // namespace diffsac
