#include <algorithm>
#include <filesystem>

#include "lab/colmap/model.h"
#include "lab/images/image_source.h"
#include "lab/images/run_pairs.h"

namespace diffsac {

ImageSource ReadColmapImages(const std::string& folder, const std::string& images) {
  ImageSource source;
  ReadColmapModel(folder, images,
                  [&](const std::string& name, const std::string& place, const std::function<ModelImage()>& read) {
                    const auto as_source = [&] {
                      const ModelImage image = read();
                      return SourceImage{ImageName(image.file), image.file, image.camera, image.pose};
                    };
                    AddImage(name.empty() ? place : ImageName(name), as_source, &source);
                  });
  return source;
}

ImageSource ReadColmap(const std::string& folder, const PairChoice& choice) {
  ImageSource source = ReadColmapImages(folder, (std::filesystem::path(folder) / "images").string());
  std::sort(source.images.begin(), source.images.end(),
            [](const SourceImage& a, const SourceImage& b) { return a.name < b.name; });
  std::vector<std::string> names;
  for (const SourceImage& image : source.images) names.push_back(image.name);
  for (const LeftOutImage& image : source.left_out) names.push_back(image.name);
  std::sort(names.begin(), names.end());
  for (SourceImage& image : source.images)
    image.frame = static_cast<int>(std::lower_bound(names.begin(), names.end(), image.name) - names.begin());
  AddAllPairs(folder, &source, choice);
  return source;
}

namespace {

const Registered<ImageFormat> kColmap("colmap", {.read = [](const PairsRequest& request) {
                                        return ReadColmap(request.input, request.choice);
                                      }});

}  // namespace

}  // namespace diffsac
