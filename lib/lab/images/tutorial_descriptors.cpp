#include "lab/images/tutorial_descriptors.h"

#include <array>
#include <filesystem>
#include <map>
#include <vector>

#include "diffsac/core/logging.h"
#include "diffsac/core/parallel.h"
#include "diffsac/core/status.h"
#include "lab/config/progress.h"
#include "lab/files/correspondence_files.h"
#include "lab/images/image_source.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Place = std::array<double, 2>;

// An image with its matched places.
struct PlacedImage {
  std::string path;
  std::map<Place, Eigen::Index> rows;
  PlacedDescriptors described;
  std::string problem;
};

using PlacedImages = std::map<std::string, PlacedImage>;

Place PlaceOf(const Example& pair, Eigen::Index match, int column) {
  return {pair.problem.points(match, column), pair.problem.points(match, column + 1)};
}

// All places of all pairs. Returns false when it was stopped.
bool CollectPlaces(const CorrespondenceScene& scene, const std::atomic<bool>& stop, PlacedImages* images) {
  Progress progress("places", scene.size());
  for (std::int64_t i = 0; i < scene.size(); ++i) {
    if (stop) return false;
    const Example pair = scene.Read(i);
    if (pair.image1.empty() || pair.image2.empty())
      throw Error(scene.folder() + ": " + pair.id + ": expected the name of a pair, img1-img2");
    for (const auto& [name, column] : {std::pair(pair.image1, 0), std::pair(pair.image2, 2)}) {
      auto& rows = (*images)[name].rows;
      for (Eigen::Index k = 0; k < pair.problem.points.rows(); ++k)
        rows.try_emplace(PlaceOf(pair, k, column), static_cast<Eigen::Index>(rows.size()));
    }
    progress.Advance();
  }
  return true;
}

void FindImages(const std::string& folder, PlacedImages* images) {
  std::map<std::string, std::string> paths;
  for (const std::string& path : ListImages(folder)) paths[ImageName(path)] = path;
  for (auto& [name, image] : *images) {
    const auto found = paths.find(name);
    if (found == paths.end()) throw Error(folder + ": there is no image " + name);
    image.path = found->second;
  }
}

bool DescribeAll(const TutorialRequest& request, const std::atomic<bool>& stop, PlacedImages* images) {
  std::vector<PlacedImage*> order;
  for (auto& entry : *images) order.push_back(&entry.second);
  {
    Progress progress("descriptors", static_cast<std::int64_t>(order.size()));
    ParallelFor(static_cast<std::int64_t>(order.size()), request.threads, [&](std::int64_t k) {
      if (stop) return;
      PlacedImage& image = *order[k];
      PointMatrix places(static_cast<Eigen::Index>(image.rows.size()), 2);
      for (const auto& [place, row] : image.rows) places.row(row) << place[0], place[1];
      try {
        image.described = DescribePlaces(image.path, places, request.features);
      } catch (const Error& error) {
        image.problem = error.what();
      }
      progress.Advance();
    });
  }
  // A file of descriptors must hold every pair, so no image can be left out.
  std::string first;
  int count = 0;
  for (const PlacedImage* image : order) {
    if (image->problem.empty()) continue;
    if (count++ == 0) first = image->problem;
  }
  if (count > 0) throw Error(first + " (" + std::to_string(count) + " images cannot be described)");
  return !stop;
}

std::vector<PairSizes> SizesOf(const CorrespondenceScene& scene, const PlacedImages& images) {
  std::vector<PairSizes> sizes;
  for (const std::string& id : scene.pairs()) {
    const std::size_t dash = id.find('-');
    sizes.push_back({id, images.at(id.substr(0, dash)).described.size, images.at(id.substr(dash + 1)).described.size});
  }
  return sizes;
}

DescriptorMatrix RowsOf(const Example& pair, const PlacedImages& images, FeatureKind kind) {
  const Eigen::Index count = pair.problem.points.rows();
  DescriptorMatrix rows(count, 256);
  for (const auto& [name, column] : {std::pair(pair.image1, 0), std::pair(pair.image2, 2)}) {
    const PlacedImage& image = images.at(name);
    ByteMatrix bytes(count, 128);
    for (Eigen::Index k = 0; k < count; ++k)
      bytes.row(k) = image.described.bytes.row(image.rows.at(PlaceOf(pair, k, column)));
    rows.middleCols(column * 64, 128) = DescriptorsFromBytes(bytes, kind);
  }
  return rows;
}

}  // namespace

TutorialResult AddTutorialDescriptors(const TutorialRequest& request, const std::atomic<bool>& stop) {
  request.features.Check();
  if (!IsSift(request.features.kind)) throw Error("--features: places are described by sift or rootsift");
  const CorrespondenceScene scene(request.input);
  TutorialResult result;
  result.pairs = scene.size();
  std::error_code code;
  if (!request.overwrite && fs::exists(fs::path(request.input) / "descriptors.h5", code)) {
    LogInfo(request.input + ": descriptors are already there; --overwrite makes them again");
    result.already_there = true;
    return result;
  }
  PlacedImages images;
  result.finished = CollectPlaces(scene, stop, &images);
  if (!result.finished) return result;
  FindImages(request.images.empty() ? (fs::path(request.input) / "images").string() : request.images, &images);
  result.finished = DescribeAll(request, stop, &images);
  if (!result.finished) return result;
  result.images = static_cast<std::int64_t>(images.size());
  for (const auto& entry : images) {
    result.places += static_cast<std::int64_t>(entry.second.rows.size());
    result.found += entry.second.described.num_found;
  }
  AddDescriptors(request.input, SizesOf(scene, images), [&](std::size_t i) {
    return RowsOf(scene.Read(static_cast<std::int64_t>(i)), images, request.features.kind);
  });
  return result;
}

}  // namespace diffsac
