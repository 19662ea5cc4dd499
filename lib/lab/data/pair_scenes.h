#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace diffsac {

/// A folder of correspondence files, with the name that its examples carry.
struct SceneFolder {
  std::string name;
  std::string folder;
};

/// Whether the folder has a `matches.h5`.
bool HoldsMatches(const std::string& folder);

/// The folder with its own name, also for "a/b/" and ".".
SceneFolder NamedFolder(const std::string& folder);

/// The folders directly in `root`, in the order of their names. Throws Error where `root` is none.
std::vector<SceneFolder> FoldersIn(const std::string& root);

/// The folders that hold matches, or another file: `root` itself or those directly in it. Throws Error when there is
/// none.
std::vector<SceneFolder> FindScenes(const std::string& root, const std::string& file = "matches.h5");

/// Those of several roots. Throws Error for a folder that is there twice.
std::vector<SceneFolder> FindScenes(const std::vector<std::string>& roots, const std::string& file = "matches.h5");

/// `count` of `size` positions, evenly spread; all of them for count 0.
std::vector<std::int64_t> EvenlySpread(std::int64_t size, int count);

}  // namespace diffsac
