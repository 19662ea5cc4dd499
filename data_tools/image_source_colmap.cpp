#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>

#include "data_tools/colmap_model.h"
#include "data_tools/colmap_text.h"
#include "data_tools/image_format.h"
#include "data_tools/image_source.h"
#include "data_tools/number_file.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

// CAMERA_ID MODEL WIDTH HEIGHT PARAMS...
std::map<std::string, LensCamera> ReadCameras(const std::string& path) {
  std::map<std::string, LensCamera> cameras;
  ColmapLines reader(path);
  while (reader.Next()) {
    const auto words = reader.Words();
    if (words.empty()) continue;
    if (words.size() < 4) reader.Fail("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS");
    const int count = ColmapParameterCount(std::string(words[1]));
    if (count == 0) reader.Fail("the camera model " + std::string(words[1]) + " is not supported");
    if (words.size() != 4 + static_cast<std::size_t>(count))
      reader.Fail("expected " + std::to_string(count) + " parameters");
    std::vector<double> parameters;
    for (std::size_t i = 4; i < words.size(); ++i) parameters.push_back(reader.Number(words[i]));
    const ImageSize size = {PixelCount(reader.Number(words[2]), reader.Place()),
                            PixelCount(reader.Number(words[3]), reader.Place())};
    cameras[std::string(words[0])] = CameraOfColmap(std::string(words[1]), parameters, size, reader.Place());
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
    const auto pose = PoseOfColmap(v);
    if (!pose) reader.Fail("expected a pose of finite numbers, with a rotation");
    const auto camera = cameras.find(std::string(words[8]));
    if (camera == cameras.end()) reader.Fail("cameras.txt has no camera " + std::string(words[8]));
    const std::string file = (fs::path(images) / std::string(words[9])).string();
    result.push_back({ImageName(file), file, camera->second, pose});
    reader.Next();
  }
  return result;
}

}  // namespace

ImageSource ReadColmap(const std::string& folder) {
  const std::string images = (fs::path(folder) / "images").string();
  const std::string binary = FindColmapModel(folder, ".bin");
  ImageSource source;
  if (!binary.empty() && FindColmapModel(folder, ".txt").empty()) {
    source.images = ReadColmapBinary(binary, images);
  } else {
    const fs::path model = ColmapModelFolder(folder);
    source.images = ReadImages((model / "images.txt").string(), images, ReadCameras((model / "cameras.txt").string()));
  }
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
