#include "diffsac/core/resources.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include "diffsac/core/config_tree.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;
using Kind = ConfigTree::Kind;

constexpr std::array<const char*, 7> kPathKeys = {"checkpoint", "start_from", "chooser", "recording",
                                                  "paths",      "root",       "folder"};
constexpr const char* kModels = "models/";

void AddOnce(const fs::path& path, std::vector<std::string>* places) {
  const std::string place = path.lexically_normal().string();
  if (std::find(places->begin(), places->end(), place) == places->end()) places->push_back(place);
}

std::vector<std::string>& AddedFolders() {
  static std::vector<std::string> folders;
  return folders;
}

bool IsThere(const std::string& path) {
  std::error_code code;
  return fs::exists(path, code);
}

/// Beside the program, wherever its prefix was moved to: as it is installed, and as a build tree has it.
std::vector<std::string> ShareFolders() {
  std::error_code code;
  const fs::path program = fs::read_symlink("/proc/self/exe", code).parent_path();
  std::vector<std::string> folders;
  if (code) return folders;
  for (const char* share : {DIFFSAC_SHARE_FROM_PROGRAMS, "../share/diffsac"}) AddOnce(program / share, &folders);
  return folders;
}

std::vector<std::string> ModelsFolders() {
  std::vector<std::string> folders;
  const char* models = std::getenv("DIFFSAC_MODELS");
  if (models != nullptr && *models != '\0') AddOnce(models, &folders);
  for (const std::string& folder : ShareFolders()) AddOnce(fs::path(folder) / kModels, &folders);
  for (const std::string& folder : AddedFolders()) AddOnce(folder, &folders);
  return folders;
}

std::vector<std::string> PlacesOf(const ConfigTree& value) {
  const fs::path path = value.scalar;
  if (path.empty() || path.is_absolute()) return {value.scalar};
  std::vector<std::string> places;
  if (!value.place.file.empty()) AddOnce(fs::path(value.place.file).parent_path() / path, &places);
  AddOnce(path, &places);
  if (value.scalar.starts_with(kModels)) {
    const fs::path name = path.lexically_relative(kModels);
    for (const std::string& folder : ModelsFolders()) AddOnce(fs::path(folder) / name, &places);
  }
  return places;
}

std::string FoundPath(const ConfigTree& value) {
  const std::vector<std::string> places = PlacesOf(value);
  const auto found = std::find_if(places.begin(), places.end(), IsThere);
  // What lies in the current folder stays as it was written.
  return found == places.end() || *found == fs::path(value.scalar).lexically_normal() ? value.scalar : *found;
}

void FindPathsOf(ConfigTree* value) {
  if (value->kind == Kind::kScalar) value->scalar = FoundPath(*value);
  for (ConfigTree& item : value->items)
    if (item.kind == Kind::kScalar) item.scalar = FoundPath(item);
}

void FindPathsIn(ConfigTree* tree) {
  for (ConfigTree& item : tree->items) FindPathsIn(&item);
  for (ConfigEntry& entry : tree->entries) {
    if (std::find(kPathKeys.begin(), kPathKeys.end(), entry.key) != kPathKeys.end()) FindPathsOf(&entry.value);
    FindPathsIn(&entry.value);
  }
}

std::string Listed(const std::vector<std::string>& places) {
  std::string text;
  for (const std::string& place : places) text += (text.empty() ? "" : ", ") + place;
  return text;
}

/// The first place where something is.
std::string FirstPlace(const std::string& what, const std::vector<std::string>& places) {
  const auto found = std::find_if(places.begin(), places.end(), IsThere);
  if (found == places.end()) throw Error(what + ": no such file; looked for " + Listed(places));
  return *found;
}

}  // namespace

std::vector<std::string> PlacesOf(const Config& value) {
  const ConfigTree* tree = value.impl_->Get();
  return tree == nullptr || tree->kind != Kind::kScalar ? std::vector<std::string>() : PlacesOf(*tree);
}

std::string RequiredPath(const Config& value, const std::string& what) {
  const std::string path = value.Text(), found = FoundPath(*value.impl_->Get());
  if (IsThere(found)) return found;
  throw Error(value.Where() + ": '" + path + "': no such " + what + "; looked for " + Listed(PlacesOf(value)));
}

void RequirePaths(const Config& config, const std::vector<std::string>& keys, const std::string& what) {
  const auto require = [&](const Config& value) {
    const ConfigTree* tree = value.impl_->Get();
    if (tree != nullptr && tree->kind == Kind::kScalar && !tree->scalar.empty()) RequiredPath(value, what);
  };
  for (const std::string& key : keys) {
    const Config value = config.Sub(key);
    const ConfigTree* tree = value.impl_->Get();
    if (tree != nullptr && tree->kind == Kind::kSequence)
      for (const Config& item : config.Sequence(key)) require(item);
    else
      require(value);
  }
}

Config WithFoundPaths(const Config& config) {
  Config found = config.Without({});
  FindPathsIn(&found.impl_->document->root);
  return found;
}

void AddModelsFolder(const std::string& folder) { AddedFolders().push_back(folder); }

std::string FindModel(const std::string& name, const std::string& folder) {
  std::vector<std::string> places;
  for (const std::string& models : folder.empty() ? ModelsFolders() : std::vector{folder})
    AddOnce(fs::path(models) / name, &places);
  return FirstPlace("model " + name, places);
}

std::string SharedFile(const std::string& name) {
  std::vector<std::string> places;
  for (const std::string& folder : ShareFolders()) AddOnce(fs::path(folder) / name, &places);
  AddOnce(name, &places);
  return FirstPlace(name, places);
}

}  // namespace diffsac
