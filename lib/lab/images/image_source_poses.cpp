#include <algorithm>
#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/images/image_format.h"
#include "lab/images/image_source.h"
#include "lab/images/number_file.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// The first of the folders that is there, or "".
std::string FirstFolder(const std::string& root, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    std::error_code code;
    const fs::path candidate = fs::path(root) / name;
    if (fs::is_directory(candidate, code)) return candidate.string();
  }
  return "";
}

// Where the files of one image are.
struct Layout {
  std::string images, poses, intrinsics;  // folders; `poses` empty: <name>.pose.txt beside the images
};

constexpr const char* kColor = ".color";

Layout FindLayout(const std::string& root) {
  std::error_code code;
  if (!fs::is_directory(root, code)) throw Error(root + ": no such folder");
  Layout layout;
  layout.poses = FirstFolder(root, {"pose", "poses"});
  layout.intrinsics = FirstFolder(root, {"intrinsic", "intrinsics"});
  layout.images = layout.poses.empty() ? root : FirstFolder(root, {"image", "images", "rgb", "color"});
  if (layout.images.empty()) throw Error(root + ": no folder image, images, rgb or color beside the poses");
  return layout;
}

std::string PosePath(const Layout& layout, const std::string& image) {
  std::string stem = fs::path(image).stem().string();
  if (!layout.poses.empty()) return (fs::path(layout.poses) / (stem + ".txt")).string();
  if (stem.ends_with(kColor)) stem.resize(stem.size() - std::string(kColor).size());
  return (fs::path(layout.images) / (stem + ".pose.txt")).string();
}

// Depth maps lie beside the images that are named so.
std::vector<std::string> ColorImages(const std::string& folder) {
  const std::vector<std::string> all = ListImages(folder);
  std::vector<std::string> color;
  std::copy_if(all.begin(), all.end(), std::back_inserter(color),
               [](const std::string& path) { return fs::path(path).stem().string().ends_with(kColor); });
  return color.empty() ? all : color;
}

SourceImage ReadPosedImage(const Layout& layout, const std::string& path, const std::optional<LensCamera>& given) {
  SourceImage image{ImageName(path), path, given, {}};
  if (!given) {
    const std::string file = fs::path(path).stem().string() + ".txt";
    image.camera.emplace().K = ReadCalibrationMatrix((fs::path(layout.intrinsics) / file).string());
  }
  const std::string pose = PosePath(layout, path);
  image.pose = WorldToCamera(ReadNumbersOf(pose, 16, "a 4x4 matrix"), pose);
  return image;
}

}  // namespace

ImageSource ReadPoses(const std::string& folder, const GivenCalibration& calibration) {
  const Layout layout = FindLayout(folder);
  const std::optional<LensCamera> given = CameraOf(calibration);
  if (!given && layout.intrinsics.empty())
    throw Error(folder + ": no folder intrinsic; give --calibration K.txt, or --focal F --center CX,CY");
  ImageSource source;
  for (const std::string& path : ColorImages(layout.images))
    AddImage(
        ImageName(path), [&] { return ReadPosedImage(layout, path, given); }, &source);
  AddAllPairs(folder, &source);
  return source;
}

namespace {

const Registered<ImageFormat> kPoses(
    "poses", {.read = [](const PairsRequest& request) { return ReadPoses(request.input, request.calibration); },
              .takes_calibration = true});

}  // namespace

}  // namespace diffsac
