#include "lab/images/photographs.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "diffsac/core/status.h"
#include "lab/colmap/database.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

bool IsPattern(const std::string& input) {
  std::error_code code;
  return input.find_first_of("*?[") != std::string::npos && !fs::exists(input, code);
}

std::vector<std::string> FilesOfPattern(const std::string& pattern) {
  glob_t found{};
  const int status = ::glob(pattern.c_str(), GLOB_BRACE, nullptr, &found);
  const std::vector<std::string> files(found.gl_pathv, found.gl_pathv + (status == 0 ? found.gl_pathc : 0));
  ::globfree(&found);
  if (files.empty()) throw Error(pattern + ": no such files");
  return files;
}

std::vector<std::string> FilesOf(const std::string& input) {
  std::error_code code;
  if (fs::is_directory(input, code)) return ListImages(input);
  if (IsPattern(input)) return FilesOfPattern(input);
  if (!fs::is_regular_file(input, code)) throw Error(input + ": no such file or folder");
  return {input};
}

std::vector<std::string> PathsOf(const std::vector<std::string>& inputs, const std::string& list) {
  std::vector<std::string> paths;
  if (inputs.empty()) paths = ImagesOfList(list);
  for (const std::string& input : inputs)
    for (const std::string& file : FilesOf(input))
      if (!PassOverOwnPicture(file)) paths.push_back(fs::path(file).lexically_normal().string());
  std::sort(paths.begin(), paths.end());
  std::set<std::string> seen;
  std::erase_if(paths, [&](const std::string& path) {
    return !seen.insert(fs::absolute(path).lexically_normal().string()).second;
  });
  return paths;
}

}  // namespace

fs::path CommonFolder(const std::vector<fs::path>& files) {
  fs::path common = files.front().parent_path();
  for (const fs::path& file : files) {
    const auto [mine, other] = std::mismatch(common.begin(), common.end(), file.begin(), file.end());
    fs::path shared;
    for (auto part = common.begin(); part != mine; ++part) shared /= *part;
    common = shared;
  }
  return common;
}

Photographs ListPhotographs(const std::vector<std::string>& inputs, const std::string& list) {
  const std::vector<std::string> paths = PathsOf(inputs, list);
  if (paths.size() < 2)
    throw Error((inputs.empty() ? list : inputs.front()) + ": expected two images at least, found " +
                (paths.empty() ? "none" : "one"));
  std::vector<fs::path> whole;
  for (const std::string& path : paths) whole.push_back(fs::absolute(path).lexically_normal());
  Photographs photographs;
  const fs::path folder = CommonFolder(whole);
  photographs.folder = folder.string();
  std::map<std::int64_t, std::string> files;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    photographs.files.push_back(whole[i].lexically_relative(folder).string());
    files[static_cast<std::int64_t>(i) + 1] = photographs.files.back();
  }
  // As they are called by those who read them from COLMAP's database.
  const std::map<std::int64_t, std::string> names = PairNames(files);
  for (std::size_t i = 0; i < paths.size(); ++i)
    photographs.source.images.push_back({names.at(static_cast<std::int64_t>(i) + 1), paths[i], {}, {}});
  PairChoice choice;
  choice.pairs_file = list;
  AddAllPairs(photographs.folder, &photographs.source, choice);
  // They may have no folder in common but the file system's.
  std::string& scene = photographs.source.scenes.front().name;
  if (scene.empty()) scene = "photographs";
  ChoosePairs(choice, photographs.folder, &photographs.source);
  return photographs;
}

bool AreTwoFiles(const std::vector<std::string>& inputs) {
  std::error_code code;
  return inputs.size() == 2 && std::none_of(inputs.begin(), inputs.end(), [&](const std::string& input) {
           return fs::is_directory(input, code) || IsPattern(input);
         });
}

}  // namespace diffsac
