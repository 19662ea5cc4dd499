#pragma once

#include <string>
#include <vector>

#include "diffsac/core/config.h"

namespace diffsac {

// Where the files are that a configuration names. One rule for all of them: a relative path is looked for
//   1. in the folder of the YAML file that it stands in (what --set or text in memory gives has none),
//   2. in the current folder,
//   3. when it begins with `models/`, in the folders of models (resources.h), then in the library.

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

}  // namespace diffsac
