#pragma once

#include <string>
#include <vector>

namespace diffsac {

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
