#pragma once

#include <string>
#include <vector>

#include "lab/options/config.h"

namespace diffsac {

// Where the files are that a configuration names. One rule for all of them: a relative path is looked for
//   1. in the folder of the YAML file that it stands in (what --set or text in memory gives has none),
//   2. in the current folder,
//   3. when it begins with `models/`, in the folders of models (below), then in the library.

/// The first of these places where something is, of the library core/embedded_models.h's. Throws Error when nothing is
/// there: file, line and key, "no such WHAT", and every place looked at.
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

/// A configuration as --config names it: as it is, else of share/diffsac beside the running program
/// ("configs/line.yaml"), or of `folder` there ("line.yaml" of "configs"). Throws Error naming every place looked at.
std::string NamedConfiguration(const std::string& name, const std::string& folder);

// Where the files are that come with the programs. Models of tables are looked for in $DIFFSAC_MODELS, then in `models`
// of share/diffsac beside the running program, which `cmake --install` fills and which in a build tree is a link to the
// sources. Those that the library carries need no file (core/embedded_models.h).

/// What an Error ends with where a model was not found.
inline constexpr const char* kModelsHint = "; the environment's DIFFSAC_MODELS names a folder of models elsewhere";

/// The folders of models, in their order.
std::vector<std::string> ModelsFolders();

/// The first file of a model ("xfeat/model.pt") in the folders of models. Throws Error naming every place looked at and
/// DIFFSAC_MODELS.
std::string FindModel(const std::string& name);

/// share/diffsac beside the running program, wherever its prefix was moved to: as it is installed, and as a build tree
/// has it.
std::vector<std::string> ShareFolders();

/// Whether there is a file or folder.
bool IsThere(const std::string& path);

/// Adds a path, unless it is among the places already.
void AddPlace(const std::string& path, std::vector<std::string>* places);

/// "a, b, c".
std::string Listed(const std::vector<std::string>& places);

/// The first of the places where something is. Throws Error naming WHAT and every place.
std::string FirstPlace(const std::string& what, const std::vector<std::string>& places);

}  // namespace diffsac
