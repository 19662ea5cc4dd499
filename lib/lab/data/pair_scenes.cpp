#include "lab/data/pair_scenes.h"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <set>
#include <utility>

#include "diffsac/core/status.h"

namespace diffsac {

namespace fs = std::filesystem;

namespace {

bool Holds(const std::string& folder, const std::string& file) {
  std::error_code code;
  return fs::exists(fs::path(folder) / file, code);
}

}  // namespace

bool HoldsMatches(const std::string& folder) { return Holds(folder, "matches.h5"); }

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

std::vector<SceneFolder> FindScenes(const std::string& root, const std::string& file) {
  std::vector<SceneFolder> scenes = FoldersIn(root);
  if (Holds(root, file)) return {NamedFolder(root)};
  std::erase_if(scenes, [&](const SceneFolder& scene) { return !Holds(scene.folder, file); });
  if (scenes.empty()) throw Error(root + ": no " + file + " in it or in a folder directly below");
  return scenes;
}

std::vector<SceneFolder> FindScenes(const std::vector<std::string>& roots, const std::string& file) {
  std::vector<SceneFolder> scenes;
  std::set<fs::path> seen;
  for (const std::string& root : roots)
    for (SceneFolder& scene : FindScenes(root, file)) {
      std::error_code code;
      if (!seen.insert(fs::weakly_canonical(scene.folder, code)).second && !code)
        throw Error("paths: '" + scene.folder + "' is there twice");
      scenes.push_back(std::move(scene));
    }
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
