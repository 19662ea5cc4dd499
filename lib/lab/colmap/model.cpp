#include "lab/colmap/model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <string_view>

#include "diffsac/core/logging.h"
#include "diffsac/core/nearest_word.h"
#include "diffsac/core/status.h"
#include "lab/colmap/lens.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"

namespace diffsac {

namespace fs = std::filesystem;

namespace {

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

// World-to-camera, of QW QX QY QZ TX TY TZ. Throws Error beginning with `place`.
RigidMotion PoseOfColmap(const double* values, const std::string& place) {
  const Eigen::Quaterniond quaternion(values[0], values[1], values[2], values[3]);
  const RigidMotion pose{quaternion.normalized().toRotationMatrix(), {values[4], values[5], values[6]}};
  // Beyond a norm of infinity no rotation is left either.
  if (!(quaternion.norm() > 0.0) || !std::isfinite(quaternion.norm()) || !pose.translation.allFinite())
    throw Error(place + ": expected a pose of finite numbers, with a rotation");
  return pose;
}

// By their ids: the cameras of a model, and what is wrong with those that make no sense, which costs their images
// alone.
struct ModelCameras {
  std::map<std::int64_t, LensCamera> cameras;
  std::map<std::int64_t, std::string> problems;

  void Read(std::int64_t id, const std::function<LensCamera()>& read) {
    try {
      cameras[id] = read();
    } catch (const Error& error) {
      problems[id] = error.what();
    }
  }

  const LensCamera& Of(std::int64_t id, const std::string& place) const {
    if (const auto camera = cameras.find(id); camera != cameras.end()) return camera->second;
    const auto problem = problems.find(id);
    if (problem != problems.end()) throw Error(problem->second);
    throw Error(place + " has no camera " + std::to_string(id));
  }
};

// CAMERA_ID (int) MODEL (int) WIDTH HEIGHT (64 bit) PARAMS (double).
ModelCameras ReadCamerasBinary(const std::string& path) {
  BinaryReader reader(path);
  ModelCameras cameras;
  for (auto left = reader.Take<std::uint64_t>(); left > 0; --left) {
    const auto id = reader.Take<std::int32_t>(), number = reader.Take<std::int32_t>();
    const int count = ColmapParameterCount(number);
    if (count == 0) throw Error(path + ": the camera model " + std::to_string(number) + " is not supported");
    ColmapCamera camera;
    camera.model = number;
    camera.has_prior_focal_length = true;
    const auto width = static_cast<double>(reader.Take<std::uint64_t>());
    const auto height = static_cast<double>(reader.Take<std::uint64_t>());
    for (int i = 0; i < count; ++i) camera.parameters.push_back(reader.Take<double>());
    cameras.Read(id, [&] {
      camera.size = {PixelCount(width, path), PixelCount(height, path)};
      return CameraOfColmap(camera, path);
    });
  }
  return cameras;
}

// Goes through the lines of a file of COLMAP's text models that are no comments.
class ColmapLines {
 public:
  explicit ColmapLines(const std::string& path) : path_(path), text_(ReadTextFile(path)), rest_(text_) {}

  // False at the end. An empty line is a line: that of an image without points.
  bool Next() {
    while (TakeLine(&rest_, &line_)) {
      ++number_;
      if (!line_.starts_with('#')) return true;
    }
    return false;
  }

  std::vector<std::string_view> Words() const { return SplitWords(line_, " \t"); }

  // What follows so many words, to the end of the line: a name, which may have blanks.
  std::string After(std::size_t words) const {
    const auto all = Words();
    if (all.size() <= words) return "";
    return {all[words].data(), static_cast<std::size_t>(all.back().data() + all.back().size() - all[words].data())};
  }

  // File and line, for messages.
  std::string Place() const { return path_ + ":" + std::to_string(number_); }
  [[noreturn]] void Fail(const std::string& what) const { throw Error(Place() + ": " + what); }

  double Number(std::string_view word) const {
    double value = 0.0;
    if (!ParseNumber(word, &value)) Fail("'" + std::string(word) + "' is no number");
    return value;
  }

  // At most 2^53 from 0: more digits than that a word cannot give.
  std::int64_t Whole(std::string_view word) const {
    const double value = Number(word);
    if (!(std::abs(value) <= 0x1p53) || value != std::floor(value))
      Fail("'" + std::string(word) + "' is no whole number");
    return static_cast<std::int64_t>(value);
  }

 private:
  std::string path_, text_;
  std::string_view rest_, line_;
  int number_ = 0;
};

// COLMAP writes capital letters.
std::string NearestModel(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::toupper(c); });
  std::vector<std::string> known;
  for (int model = 0; const auto model_name = ColmapModelName(model); ++model) known.push_back(*model_name);
  return NearestWord(name, known);
}

// CAMERA_ID MODEL WIDTH HEIGHT PARAMS...
LensCamera ReadCamera(const ColmapLines& reader) {
  const auto words = reader.Words();
  if (words.size() < 4) reader.Fail("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
  const std::optional<int> model = ColmapModelNumber(words[1]);
  if (!model)
    reader.Fail("the camera model " + std::string(words[1]) +
                " is not supported: " + NearestModel(std::string(words[1])) + " is the nearest");
  ColmapCamera camera;
  camera.model = *model;
  camera.has_prior_focal_length = true;
  const int count = ColmapParameterCount(*model);
  if (words.size() != 4 + static_cast<std::size_t>(count))
    reader.Fail("expected " + std::to_string(count) + " parameters");
  for (std::size_t i = 4; i < words.size(); ++i) camera.parameters.push_back(reader.Number(words[i]));
  camera.size = {PixelCount(reader.Number(words[2]), reader.Place()),
                 PixelCount(reader.Number(words[3]), reader.Place())};
  return CameraOfColmap(camera, reader.Place());
}

ModelCameras ReadCamerasText(const std::string& path) {
  ModelCameras cameras;
  ColmapLines reader(path);
  while (reader.Next()) {
    if (reader.Words().empty()) continue;
    try {
      cameras.Read(reader.Whole(reader.Words()[0]), [&] { return ReadCamera(reader); });
    } catch (const Error& error) {
      LogWarning(std::string("left out: ") + error.what());  // Nobody knows whose it is.
    }
  }
  return cameras;
}

// IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, each followed by a line of points, which may be empty.
void ReadImagesText(const std::string& path, const std::string& images, const ModelCameras& cameras,
                    const UseModelImage& use) {
  ColmapLines reader(path);
  const auto read = [&](const std::vector<std::string_view>& words) {
    if (words.size() < 10) reader.Fail("expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    double v[7];
    for (int i = 0; i < 7; ++i) v[i] = reader.Number(words[1 + i]);
    const RigidMotion pose = PoseOfColmap(v, reader.Place() + ": " + reader.After(9));
    const LensCamera& camera = cameras.Of(reader.Whole(words[8]), reader.Place() + ": cameras.txt");
    const std::string file = (fs::path(images) / reader.After(9)).string();
    return ModelImage{file, camera, pose};
  };
  while (reader.Next()) {
    const auto words = reader.Words();
    if (words.empty()) continue;
    use(reader.After(9), reader.Place(), [&] { return read(words); });
    reader.Next();
  }
}

// IMAGE_ID (int) QW QX QY QZ TX TY TZ (double) CAMERA_ID (int) NAME, and points: X Y (double) POINT3D_ID (64 bit).
void ReadImagesBinary(const std::string& model, const std::string& images, const UseModelImage& use) {
  constexpr std::uint64_t kPointBytes = 24;
  const auto cameras = ReadCamerasBinary((fs::path(model) / "cameras.bin").string());
  const std::string path = (fs::path(model) / "images.bin").string();
  BinaryReader reader(path);
  for (auto left = reader.Take<std::uint64_t>(); left > 0; --left) {
    reader.Take<std::int32_t>();
    double values[7];
    for (double& value : values) value = reader.Take<double>();
    const auto id = reader.Take<std::int32_t>();
    const std::string file = (fs::path(images) / reader.TakeText()).string();
    reader.Skip(reader.Take<std::uint64_t>(), kPointBytes);
    const auto read = [&] {
      const RigidMotion pose = PoseOfColmap(values, path + ": " + file);
      return ModelImage{file, cameras.Of(id, path + ": " + file + ": cameras.bin"), pose};
    };
    use(file, path, read);
  }
}

}  // namespace

std::map<std::int64_t, LensCamera> ReadColmapCameras(const std::string& path) {
  ModelCameras read = path.ends_with(".bin") ? ReadCamerasBinary(path) : ReadCamerasText(path);
  if (read.cameras.empty() && !read.problems.empty()) throw Error(read.problems.begin()->second);
  for (const auto& [id, problem] : read.problems) LogWarning("left out: " + problem);
  return std::move(read.cameras);
}

void ReadColmapModel(const std::string& folder, const std::string& images, const UseModelImage& use) {
  const std::string binary = FindColmapModel(folder, ".bin");
  if (!binary.empty() && FindColmapModel(folder, ".txt").empty()) return ReadImagesBinary(binary, images, use);
  const fs::path model = FindColmapModel(folder, ".txt");
  if (model.empty()) throw Error(folder + ": no COLMAP text model (cameras.txt, images.txt)");
  ReadImagesText((model / "images.txt").string(), images, ReadCamerasText((model / "cameras.txt").string()), use);
}

std::string FindColmapModel(const std::string& folder, const std::string& extension) {
  for (const char* name : {"", "colmap_ground_truth", "sparse/0", "sparse"}) {
    const fs::path candidate = fs::path(folder) / name;
    if (fs::exists(candidate / ("cameras" + extension)) && fs::exists(candidate / ("images" + extension)))
      return candidate.string();
  }
  return "";
}

}  // namespace diffsac
