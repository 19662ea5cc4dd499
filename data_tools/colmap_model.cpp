#include "data_tools/colmap_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>

#include "data_tools/number_file.h"
#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "diffsac/io/colmap_lens.h"

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

// Little-endian numbers one after the other.
class BinaryReader {
 public:
  explicit BinaryReader(const std::string& path) : path_(path), content_(ReadFile(path)) {}

  template <class T>
  T Take() {
    T value;
    std::memcpy(&value, Bytes(sizeof value), sizeof value);
    return value;
  }

  /// To the next zero.
  std::string TakeText() {
    std::string text;
    while (const char c = *Bytes(1)) text += c;
    return text;
  }

  void Skip(std::uint64_t count, std::uint64_t bytes) {
    if (count > Left() / bytes) FailAtEnd();
    position_ += count * bytes;
  }

 private:
  std::uint64_t Left() const { return content_.size() - position_; }
  [[noreturn]] void FailAtEnd() const {
    throw Error(path_ + ": ends early; not a binary model of COLMAP, or truncated");
  }

  const char* Bytes(std::size_t count) {
    if (count > Left()) FailAtEnd();
    const char* bytes = content_.data() + position_;
    position_ += count;
    return bytes;
  }

  std::string path_, content_;
  std::uint64_t position_ = 0;
};

// CAMERA_ID (int) MODEL (int) WIDTH HEIGHT (64 bit) PARAMS (double).
std::map<std::int32_t, LensCamera> ReadCameras(const std::string& path) {
  BinaryReader reader(path);
  std::map<std::int32_t, LensCamera> cameras;
  for (auto left = reader.Take<std::uint64_t>(); left > 0; --left) {
    const auto id = reader.Take<std::int32_t>(), number = reader.Take<std::int32_t>();
    const std::string model = ColmapModelName(number).value_or(std::to_string(number));
    const int count = ColmapParameterCount(model);
    if (count == 0) throw Error(path + ": the camera model " + model + " is not supported");
    ImageSize size;
    size.width = PixelCount(static_cast<double>(reader.Take<std::uint64_t>()), path);
    size.height = PixelCount(static_cast<double>(reader.Take<std::uint64_t>()), path);
    std::vector<double> parameters;
    for (int i = 0; i < count; ++i) parameters.push_back(reader.Take<double>());
    cameras[id] = CameraOfColmap(model, parameters, size, path);
  }
  return cameras;
}

}  // namespace

int ColmapParameterCount(const std::string& model) {
  const auto found = CameraModels().find(model);
  return found == CameraModels().end() ? 0 : static_cast<int>(found->second.size());
}

LensCamera CameraOfColmap(const std::string& model, const std::vector<double>& parameters, const ImageSize& size,
                          const std::string& place) {
  std::map<std::string, double> p;
  const std::vector<std::string>& names = CameraModels().at(model);
  for (std::size_t i = 0; i < names.size(); ++i) p[names[i]] = parameters[i];
  const auto get = [&](const char* name, const char* other = "") {
    const auto found = p.count(name) > 0 ? p.find(name) : p.find(other);
    return found == p.end() ? 0.0 : found->second;
  };
  LensCamera camera;
  camera.K << get("fx", "f"), 0.0, get("cx") - 0.5, 0.0, get("fy", "f"), get("cy") - 0.5, 0.0, 0.0, 1.0;
  camera.k1 = get("k1");
  camera.k2 = get("k2");
  camera.p1 = get("p1");
  camera.p2 = get("p2");
  camera.size = size;
  const bool finite =
      std::all_of(parameters.begin(), parameters.end(), [](double value) { return std::isfinite(value); });
  if (!finite || !(camera.K(0, 0) > 0.0) || !(camera.K(1, 1) > 0.0))
    throw Error(place + ": expected finite camera parameters, and positive focal lengths");
  return camera;
}

std::optional<RigidMotion> PoseOfColmap(const double* values) {
  const Eigen::Quaterniond quaternion(values[0], values[1], values[2], values[3]);
  // Beyond a norm of infinity no rotation is left either.
  if (!(quaternion.norm() > 0.0) || !std::isfinite(quaternion.norm())) return {};
  RigidMotion pose;
  pose.rotation = quaternion.normalized().toRotationMatrix();
  pose.translation << values[4], values[5], values[6];
  if (!pose.translation.allFinite()) return {};
  return pose;
}

// IMAGE_ID (int) QW QX QY QZ TX TY TZ (double) CAMERA_ID (int) NAME, and points: X Y (double) POINT3D_ID (64 bit).
std::vector<SourceImage> ReadColmapBinary(const std::string& model, const std::string& images) {
  constexpr std::uint64_t kPointBytes = 24;
  const auto cameras = ReadCameras((fs::path(model) / "cameras.bin").string());
  const std::string path = (fs::path(model) / "images.bin").string();
  BinaryReader reader(path);
  std::vector<SourceImage> result;
  for (auto left = reader.Take<std::uint64_t>(); left > 0; --left) {
    reader.Take<std::int32_t>();
    double values[7];
    for (double& value : values) value = reader.Take<double>();
    const auto camera = cameras.find(reader.Take<std::int32_t>());
    const std::string file = (fs::path(images) / reader.TakeText()).string();
    reader.Skip(reader.Take<std::uint64_t>(), kPointBytes);
    const auto pose = PoseOfColmap(values);
    if (!pose) throw Error(path + ": " + file + ": expected a pose of finite numbers, with a rotation");
    if (camera == cameras.end()) throw Error(path + ": " + file + ": cameras.bin has no such camera");
    result.push_back({ImageName(file), file, camera->second, pose});
  }
  return result;
}

}  // namespace diffsac
