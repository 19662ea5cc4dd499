#include "lab/data/ransac_tutorial_dataset.h"

#include <algorithm>
#include <filesystem>

#include "diffsac/core/nearest_word.h"
#include "diffsac/core/status.h"
#include "lab/config/dataset_registry.h"

namespace diffsac {
namespace {

std::vector<SceneFolder> AllScenes(const std::string& root, const std::string& split) {
  const std::vector<SceneFolder> folders = FoldersIn(root);
  const std::string inner = root + "/" + split;
  if (HoldsMatches(inner)) return {{NamedFolder(root).name, inner}};
  std::vector<SceneFolder> scenes;
  std::error_code code;
  if (std::filesystem::is_directory(inner, code)) scenes = FoldersIn(inner);
  std::erase_if(scenes, [](const SceneFolder& scene) { return !HoldsMatches(scene.folder); });
  if (scenes.empty())
    for (const auto& [name, folder] : folders)
      if (HoldsMatches(folder + "/" + split)) scenes.push_back({name, folder + "/" + split});
  if (scenes.empty()) throw Error(inner + ": no scenes (folders with matches.h5) of this split");
  return scenes;
}

std::vector<SceneFolder> ChosenScenes(const RansacTutorialOptions& options) {
  const auto found = AllScenes(options.root, options.split == "validation" ? "val" : options.split);
  if (options.scenes.empty()) return found;
  std::vector<SceneFolder> chosen;
  std::vector<std::string> known;
  for (const SceneFolder& scene : found) known.push_back(scene.name);
  for (const std::string& name : options.scenes) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end())
      throw Error(options.root + ": no scene '" + name + "'; did you mean '" + NearestWord(name, known) + "'?");
    chosen.push_back(found[static_cast<std::size_t>(at - known.begin())]);
  }
  return chosen;
}

}  // namespace

void RansacTutorialOptions::Bind(OptionsBinder& b) {
  b.Field("root", root).Help("a folder: <root>/<split>/<scene>, or <root>/<scene>/<split>");
  b.Choice("split", split, {"train", "val", "test", "validation"}).Help("the folder; validation means val");
  b.Field("scenes", scenes).Help("names; empty: all");
  pairs.Bind(b, "snn_threshold");
  b.Require(!root.empty(), "root", "a folder");
}

std::unique_ptr<Dataset> MakeRansacTutorial(const RansacTutorialOptions& options, std::uint64_t seed) {
  CheckOptions(options);
  return MakePairDataset(ChosenScenes(options), options.pairs, PairMemory::kRecent, seed);
}

namespace {

const RegisteredDataset<RansacTutorialOptions> kRansacTutorial(
    "ransac_tutorial", DataSource::kFiles,
    "The CVPR 2020 RANSAC tutorial's correspondence files; a pair is read when it is asked for.", MakeRansacTutorial);

}  // namespace

}  // namespace diffsac
