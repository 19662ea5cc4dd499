#include "lab/config/meant_paths.h"

#include <algorithm>

namespace diffsac {
namespace {

void AddPaths(const Config& config, const std::string& place, std::vector<std::string>* paths) {
  for (const std::string& key : config.Keys()) {
    paths->push_back(place.empty() ? key : place + "." + key);
    AddPaths(config.Sub(key), paths->back(), paths);
  }
}

/// At most three, in the order of the documents.
std::string EndingIn(const std::string& path, const std::vector<std::string>& paths) {
  constexpr int kMost = 3;
  std::string text;
  int count = 0;
  for (const std::string& candidate : paths)
    if ((candidate == path || candidate.ends_with("." + path)) && count++ < kMost)
      text += (text.empty() ? "'" : ", '") + candidate + "'";
  return text;
}

}  // namespace

std::string WithMeantPaths(const Error& error, const std::vector<std::string>& assignments,
                           const std::function<std::vector<PlacedConfig>()>& documents) {
  const std::string message = error.what();
  const auto of = std::find_if(assignments.begin(), assignments.end(), [&](const std::string& assignment) {
    return message.starts_with("--set " + assignment + ": unknown key");
  });
  if (of == assignments.end()) return message;
  std::vector<std::string> paths;
  for (const auto& [place, config] : documents()) AddPaths(config, place, &paths);
  const std::string path = of->substr(0, of->find('='));
  std::string meant = EndingIn(path, paths);
  if (meant.empty()) meant = EndingIn(path.substr(path.rfind('.') + 1), paths);
  if (meant.empty()) return message;
  return message.substr(0, message.find("; did you mean")) + "; did you mean " + meant + "?";
}

}  // namespace diffsac
