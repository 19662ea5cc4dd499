#include "lab/config/resources.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "diffsac/core/status.h"

namespace diffsac {

namespace fs = std::filesystem;

void AddPlace(const std::string& path, std::vector<std::string>* places) {
  const std::string place = fs::path(path).lexically_normal().string();
  if (std::find(places->begin(), places->end(), place) == places->end()) places->push_back(place);
}

std::string Listed(const std::vector<std::string>& places) {
  std::string text;
  for (const std::string& place : places) text += (text.empty() ? "" : ", ") + place;
  return text;
}

bool IsThere(const std::string& path) {
  std::error_code code;
  return fs::exists(path, code);
}

std::vector<std::string> ShareFolders() {
  std::error_code code;
  const fs::path program = fs::read_symlink("/proc/self/exe", code);
  std::vector<std::string> folders;
  if (code) return folders;
  for (const char* share : {DIFFSAC_SHARE_FROM_BIN, "../share/diffsac"})
    AddPlace(program.parent_path() / share, &folders);
  return folders;
}

std::vector<std::string> ModelsFolders() {
  std::vector<std::string> folders;
  const char* models = std::getenv("DIFFSAC_MODELS");
  if (models != nullptr && *models != '\0') AddPlace(models, &folders);
  for (const std::string& folder : ShareFolders()) AddPlace(fs::path(folder) / "models", &folders);
  return folders;
}

std::string FirstPlace(const std::string& what, const std::vector<std::string>& places) {
  const auto found = std::find_if(places.begin(), places.end(), IsThere);
  if (found == places.end()) throw Error(what + ": no such file; looked for " + Listed(places));
  return *found;
}

std::string FindModel(const std::string& name) {
  std::vector<std::string> places;
  for (const std::string& models : ModelsFolders()) AddPlace(fs::path(models) / name, &places);
  try {
    return FirstPlace("model " + name, places);
  } catch (const Error& error) {
    throw Error(error.what() + std::string(kModelsHint));
  }
}

}  // namespace diffsac
