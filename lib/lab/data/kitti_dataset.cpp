#include "lab/data/kitti_dataset.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "diffsac/core/status.h"
#include "lab/config/dataset_registry.h"

namespace diffsac {
namespace {

// The sequence and step in "kitti_00_step_01".
std::optional<std::pair<std::string, int>> ParseKittiScene(const std::string& name) {
  constexpr std::string_view kStart = "kitti_", kMiddle = "_step_";
  const std::size_t middle = name.find(kMiddle);
  if (!name.starts_with(kStart) || middle == std::string::npos) return {};
  int step = 0;
  const char* end = name.data() + name.size();
  const auto read = std::from_chars(name.data() + middle + kMiddle.size(), end, step);
  if (read.ec != std::errc() || read.ptr != end) return {};
  return std::pair(name.substr(kStart.size(), middle - kStart.size()), step);
}

template <class Item>
bool Wanted(const std::vector<Item>& wanted, const Item& item) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), item) != wanted.end();
}

std::vector<SceneFolder> FindKittiScenes(const KittiOptions& options) {
  std::vector<SceneFolder> scenes = FoldersIn(options.root);
  std::erase_if(scenes, [&](const SceneFolder& folder) {
    const auto scene = ParseKittiScene(folder.name);
    return !scene || !HoldsMatches(folder.folder) || !Wanted(options.sequences, scene->first) ||
           !Wanted(options.steps, scene->second);
  });
  if (scenes.empty())
    throw Error(options.root +
                ": no scenes kitti_<sequence>_step_<step> of these sequences and steps (diffsac_prepare makes them)");
  return scenes;
}

}  // namespace

void KittiOptions::Bind(OptionsBinder& b) {
  b.Field("root", root).Help("a folder with scenes kitti_<sequence>_step_<step>");
  b.Field("sequences", sequences).Help("empty: all");
  b.Field("steps", steps, AtLeast(1)).Help("frames between the images of a pair; empty: all");
  pairs.Bind(b, "snn_threshold");
  b.Require(!root.empty(), "root", "a folder");
}

std::unique_ptr<Dataset> MakeKitti(const KittiOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  return MakePairDataset(FindKittiScenes(options), options.pairs, PairMemory::kRecent, seed);
}

namespace {

const RegisteredDataset<KittiOptions> kKitti(
    "kitti", DataSource::kFiles,
    "KITTI odometry as `diffsac_prepare pairs --format kitti` writes it; a pair is read when it is asked for.",
    MakeKitti);

}  // namespace

}  // namespace diffsac
