#include <charconv>
#include <cstdio>
#include <filesystem>

#include "data_tools/image_source.h"
#include "data_tools/number_file.h"
#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "diffsac/data/text_scan.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// "P0: " and twelve numbers, a row-major 3 × 4 matrix; the left grey camera is the origin, so its left part is K.
LensCamera ReadCalibration(const std::string& path) {
  const std::string text = ReadFile(path);
  std::string_view rest = text, line;
  for (int number = 1; TakeLine(&rest, &line); ++number) {
    const auto words = SplitWords(line, " \t");
    if (words.empty() || words[0] != "P0:") continue;
    double p[12];
    bool good = words.size() == 13;
    for (int i = 0; good && i < 12; ++i) good = ParseNumber(words[i + 1], &p[i]);
    if (!good) throw Error(path + ":" + std::to_string(number) + ": expected twelve numbers after P0:");
    LensCamera camera;
    camera.K << p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10];
    return camera;
  }
  throw Error(path + ": no line P0:");
}

RigidMotion PoseOf(const std::vector<double>& v) {
  RigidMotion to_world;
  to_world.rotation << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  to_world.translation << v[3], v[7], v[11];
  return Inverse(to_world);
}

int FrameNumber(const std::string& path) {
  const std::string name = fs::path(path).stem().string();
  int number = -1;
  const auto result = std::from_chars(name.data(), name.data() + name.size(), number);
  if (result.ec != std::errc() || result.ptr != name.data() + name.size() || number < 0)
    throw Error(path + ": expected a frame's number as name");
  return number;
}

std::string SceneName(const std::string& sequence, int step) {
  char text[32];
  std::snprintf(text, sizeof(text), "_step_%02d", step);
  return "kitti_" + sequence + text;
}

}  // namespace

ImageSource ReadKitti(const std::string& root, const std::string& sequence, const std::vector<int>& steps) {
  const fs::path folder = fs::path(root) / "sequences" / sequence;
  const std::string pose_path = (fs::path(root) / "poses" / (sequence + ".txt")).string();
  const LensCamera camera = ReadCalibration((folder / "calib.txt").string());
  const auto poses = ReadNumberFile(pose_path, 12);
  ImageSource source;
  std::vector<int> image_of_frame(poses.size(), -1);
  for (const std::string& path : ListImages((folder / "image_0").string())) {
    const int frame = FrameNumber(path);
    if (frame >= static_cast<int>(poses.size())) throw Error(pose_path + ": no pose for " + path);
    image_of_frame[frame] = static_cast<int>(source.images.size());
    source.images.push_back({ImageName(path), path, camera, PoseOf(poses[frame].values)});
  }
  if (steps.empty()) throw Error("steps: expected at least one");
  for (int step : steps) {
    if (step < 1) throw Error("steps: expected positive numbers, found " + std::to_string(step));
    SourceScene scene{SceneName(sequence, step), {}};
    for (int i = 0; i + step < static_cast<int>(poses.size()); ++i)
      if (image_of_frame[i] >= 0 && image_of_frame[i + step] >= 0)
        scene.pairs.push_back({image_of_frame[i], image_of_frame[i + step], {}});
    source.scenes.push_back(std::move(scene));
  }
  CheckSource(source, folder.string());
  return source;
}

}  // namespace diffsac
