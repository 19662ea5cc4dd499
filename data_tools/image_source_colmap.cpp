#include <algorithm>
#include <filesystem>

#include "data_tools/colmap_model.h"
#include "data_tools/image_format.h"
#include "data_tools/image_source.h"

namespace diffsac {

ImageSource ReadColmap(const std::string& folder) {
  ImageSource source;
  source.images = ReadColmapModel(folder, (std::filesystem::path(folder) / "images").string());
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
