#pragma once

#include <string>
#include <vector>

#include "diffsac/core/config.h"

namespace diffsac {

// Where the files are that a configuration names, and those that come with the programs. One rule for all of them:
//
// a relative path of a configuration is looked for
//   1. in the folder of the YAML file that it stands in (what --set or text in memory gives has none),
//   2. in the current folder,
//   3. when it begins with `models/`, in the folders of models: $DIFFSAC_MODELS, then `models` of share/diffsac beside
//      the running program, which `cmake --install` fills and which in a build tree is a link to the sources, then
//      those of AddModelsFolder.

/// Models are looked for in this folder as well, after the others. Programs of others that link an installed library
/// call it with their prefix's folder when they start (diffsac/diffsac.h).
void AddModelsFolder(const std::string& folder);

/// The file of a model ("fundamental/model.safetensors"): in `folder` alone where one is given, else in the folders of
/// models. Throws Error naming every place looked at.
std::string FindModel(const std::string& name, const std::string& folder = "");

/// The places where the path that `value` holds is looked for, in order. An absolute one is its own place.
std::vector<std::string> PlacesOf(const Config& value);

/// The first of these places where something is. Throws Error when nothing is there: file, line and key, "no such
/// WHAT", and every place looked at.
std::string RequiredPath(const Config& value, const std::string& what);

/// The same for each path that the keys, or lists at the keys, hold; keys that are not there are passed over.
void RequirePaths(const Config& config, const std::vector<std::string>& keys, const std::string& what);

/// The document with those places in it that its paths were found at: the values, or lists of values, of `checkpoint`,
/// `start_from`, `chooser`, `recording`, `paths`, `root` and `folder`, at any depth. What is nowhere stays as it was
/// written.
Config WithFoundPaths(const Config& config);

/// A file that comes with the programs ("configs/pair/homography.yaml"): of share/diffsac beside the running program,
/// or else of the current folder. Throws Error naming every place looked at.
std::string SharedFile(const std::string& name);

}  // namespace diffsac
