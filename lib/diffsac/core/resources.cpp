#include "diffsac/core/resources.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModels = "models/";

std::vector<std::string>& AddedFolders() {
  static std::vector<std::string> folders;
  return folders;
}

}  // namespace

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
  // A shared library finds them as well, whatever program loaded it.
  Dl_info here;
  if (::dladdr(reinterpret_cast<const void*>(&ShareFolders), &here) == 0) return folders;
  const fs::path library = here.dli_fname;
  if (library.is_absolute() && library != program) AddPlace(library.parent_path() / DIFFSAC_SHARE_FROM_LIB, &folders);
  return folders;
}

std::vector<std::string> ModelsFolders() {
  std::vector<std::string> folders;
  const char* models = std::getenv("DIFFSAC_MODELS");
  if (models != nullptr && *models != '\0') AddPlace(models, &folders);
  for (const std::string& folder : ShareFolders()) AddPlace(fs::path(folder) / kModels, &folders);
  for (const std::string& folder : AddedFolders()) AddPlace(folder, &folders);
  return folders;
}

std::string FirstPlace(const std::string& what, const std::vector<std::string>& places) {
  const auto found = std::find_if(places.begin(), places.end(), IsThere);
  if (found == places.end()) throw Error(what + ": no such file; looked for " + Listed(places));
  return *found;
}

void AddModelsFolder(const std::string& folder) {
  // The header diffsac.h as the compiler read it (cmake/diffsac.pc.in) stands for the models of its prefix.
  const fs::path headers = fs::path(folder).parent_path();
  const bool is_header = fs::path(folder).filename() == "diffsac.h";
  AddedFolders().push_back(is_header ? (headers / ".." / DIFFSAC_SHARE_FROM_INCLUDE / kModels).string() : folder);
}

std::string FindModel(const std::string& name, const std::string& folder) {
  std::vector<std::string> places;
  for (const std::string& models : folder.empty() ? ModelsFolders() : std::vector{folder})
    AddPlace(fs::path(models) / name, &places);
  try {
    return FirstPlace("model " + name, places);
  } catch (const Error& error) {
    // A prefix that was moved, or models that were installed elsewhere.
    throw Error(error.what() + std::string(folder.empty() ? kModelsHint : ""));
  }
}

}  // namespace diffsac
