#include "diffsac/data/pair_scenes.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "diffsac/core/status.h"

namespace diffsac {

namespace fs = std::filesystem;

bool HoldsMatches(const std::string& folder) {
  std::error_code code;
  return fs::exists(fs::path(folder) / "matches.h5", code);
}

SceneFolder NamedFolder(const std::string& folder) {
  std::error_code code;
  const fs::path whole = fs::weakly_canonical(folder, code);
  return {(code ? fs::path(folder) : whole).filename().string(), folder};
}

std::vector<SceneFolder> FoldersIn(const std::string& root) {
  std::error_code code;
  if (!fs::is_directory(root, code)) throw Error(root + ": no such folder");
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(root, code))
    if (entry.is_directory()) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<SceneFolder> folders;
  for (const fs::path& path : paths) folders.push_back(NamedFolder(path.string()));
  return folders;
}

std::vector<SceneFolder> FindScenes(const std::string& root) {
  std::vector<SceneFolder> scenes = FoldersIn(root);
  if (HoldsMatches(root)) return {NamedFolder(root)};
  std::erase_if(scenes, [](const SceneFolder& scene) { return !HoldsMatches(scene.folder); });
  if (scenes.empty()) throw Error(root + ": no matches.h5 in it or in a folder directly below");
  return scenes;
}

std::vector<std::int64_t> EvenlySpread(std::int64_t size, int count) {
  if (count == 0 || count >= size) {
    std::vector<std::int64_t> all(size);
    std::iota(all.begin(), all.end(), 0);
    return all;
  }
  std::vector<std::int64_t> positions;
  for (int i = 0; i < count; ++i) positions.push_back(i * size / count);
  return positions;
}

}  // namespace diffsac
