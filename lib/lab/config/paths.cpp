#include "lab/config/paths.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include "diffsac/core/embedded_models.h"
#include "diffsac/core/status.h"
#include "lab/options/config_tree.h"

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

namespace {

using Kind = ConfigTree::Kind;

constexpr std::array<const char*, 7> kPathKeys = {"checkpoint", "start_from", "chooser", "recording",
                                                  "paths",      "root",       "folder"};
constexpr std::string_view kModels = "models/";

std::vector<std::string> PlacesOf(const ConfigTree& value) {
  const fs::path path = value.scalar;
  if (path.empty() || path.is_absolute()) return {value.scalar};
  std::vector<std::string> places;
  if (!value.place.file.empty()) AddPlace(fs::path(value.place.file).parent_path() / path, &places);
  AddPlace(path.string(), &places);
  if (value.scalar.starts_with(kModels)) {
    const fs::path name = path.lexically_relative(kModels);
    for (const std::string& folder : ModelsFolders()) AddPlace(fs::path(folder) / name, &places);
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

}  // namespace

std::string RequiredPath(const Config& value, const std::string& what) {
  const std::string path = value.Text(), found = FoundPath(*value.impl_->Get());
  if (IsThere(found)) return found;
  if (path.starts_with(kModels)) {
    const std::string embedded = ModelPlace(path.substr(kModels.size()));
    if (!EmbeddedModel(embedded).empty()) return embedded;
  }
  throw Error(value.Where() + ": '" + path + "': no such " + what + "; looked for " +
              Listed(PlacesOf(*value.impl_->Get())) + (path.starts_with(kModels) ? kModelsHint : ""));
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

std::string NamedConfiguration(const std::string& name, const std::string& folder) {
  std::vector<std::string> places = {name};
  for (const std::string& share : ShareFolders())
    for (const std::string& place : {folder, std::string()}) AddPlace(fs::path(share) / place / name, &places);
  return FirstPlace(name, places);
}

std::string SharedFile(const std::string& name) {
  std::vector<std::string> places;
  for (const std::string& folder : ShareFolders()) AddPlace(fs::path(folder) / name, &places);
  AddPlace(name, &places);
  return FirstPlace(name, places);
}

}  // namespace diffsac
