#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"
#include "lab/images/image_source.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

constexpr int kLeftOut = -1;

// A pair list may name an image by its file, with folders before it, or without the extension.
class ImageNames {
 public:
  explicit ImageNames(const ImageSource& source) {
    for (const LeftOutImage& image : source.left_out) index_[image.name] = kLeftOut;
    for (std::size_t i = 0; i < source.images.size(); ++i) {
      index_[source.images[i].name] = static_cast<int>(i);
      index_[fs::path(source.images[i].path).filename().string()] = static_cast<int>(i);
    }
    for (std::size_t i = 0; i < source.images.size(); ++i) index_[source.images[i].path] = static_cast<int>(i);
  }

  // kLeftOut for an image that is known but cannot be used; false for an unknown one.
  bool Find(const std::string& text, int* index) const {
    for (const std::string& name : {text, fs::path(text).filename().string(), ImageName(text), WithUnderscores(text)}) {
      const auto found = index_.find(name);
      if (found == index_.end()) continue;
      *index = found->second;
      return true;
    }
    return false;
  }

 private:
  static std::string WithUnderscores(std::string text) {
    std::replace(text.begin(), text.end(), '-', '_');
    return text;
  }

  std::map<std::string, int> index_;
};

// A file of the list's folder where there is one, as it stands where not.
std::string PathInList(const std::string& list, const std::string& name) {
  const fs::path beside = (fs::path(list).parent_path() / name).lexically_normal();
  std::error_code code;
  return fs::exists(beside, code) ? beside.string() : fs::path(name).lexically_normal().string();
}

std::string_view Trimmed(std::string_view text) {
  const std::size_t start = std::min(text.find_first_not_of(" \t\r"), text.size());
  return text.substr(start, text.find_last_not_of(" \t\r") + 1 - start);
}

// A line of a list of pairs.
struct ListedPair {
  std::string place;  // file and line
  std::string names[2];
};

// The two names of a line: on either side of a tab or a comma, or where both are known; names may have blanks.
std::vector<std::string> NamesOfLine(std::string_view line, const std::function<bool(const std::string&)>& is_known) {
  for (const char* separators : {"\t", ",", " \t,"}) {
    std::vector<std::string> names;
    for (std::string_view word : SplitWords(line, separators))
      if (const auto trimmed = Trimmed(word); !trimmed.empty()) names.emplace_back(trimmed);
    if (names.size() == 2) return names;
  }
  std::vector<std::vector<std::string>> found;
  for (std::size_t at = line.find(' '); at != std::string_view::npos; at = line.find(' ', at + 1)) {
    std::vector<std::string> names = {std::string(Trimmed(line.substr(0, at))), std::string(Trimmed(line.substr(at)))};
    if (line[at + 1] != ' ' && is_known(names[0]) && is_known(names[1])) found.push_back(std::move(names));
  }
  return found.size() == 1 ? found[0] : std::vector<std::string>();
}

std::vector<ListedPair> ReadListedPairs(const std::string& path,
                                        const std::function<bool(const std::string&)>& is_known) {
  // Of FILE#NAME the part that begins with the line [NAME].
  const std::size_t mark = path.rfind('#');
  const bool in_parts = mark != std::string::npos && !std::filesystem::exists(path);
  const std::string file = in_parts ? path.substr(0, mark) : path;
  const std::string heading = in_parts ? "[" + path.substr(mark + 1) + "]" : "";
  const std::string text = ReadTextFile(file);
  std::vector<ListedPair> pairs;
  std::string_view rest = text, line;
  bool inside = !in_parts, found = inside;
  for (int number = 1; TakeLine(&rest, &line); ++number) {
    line = Trimmed(line);
    if (in_parts && line.starts_with('[')) found |= inside = line == heading;
    if (!inside || line.empty() || line.starts_with('#') || line == heading) continue;
    const std::string place = file + ":" + std::to_string(number);
    const std::vector<std::string> names = NamesOfLine(line, is_known);
    if (names.empty())
      throw Error(place + ": expected the names of two images; with a tab between them where they have blanks");
    pairs.push_back({place, {names[0], names[1]}});
  }
  if (!found) throw Error(file + ": there is no part " + heading);
  return pairs;
}

std::vector<SourcePair> ReadPairList(const std::string& path, const ImageSource& source) {
  const ImageNames names(source);
  std::vector<SourcePair> pairs;
  std::set<std::pair<int, int>> seen;
  const auto find = [&](const std::string& name, int* index) {
    return names.Find(PathInList(path, name), index) || names.Find(name, index);
  };
  const auto is_known = [&](const std::string& name) {
    int index = 0;
    return find(name, &index);
  };
  for (const auto& [place, words] : ReadListedPairs(path, is_known)) {
    int index[2];
    for (int i = 0; i < 2; ++i)
      if (!find(words[i], &index[i])) throw Error(place + ": there is no image " + words[i]);
    if (index[0] == kLeftOut || index[1] == kLeftOut) continue;
    if (index[0] == index[1]) throw Error(place + ": an image cannot be paired with itself");
    if (!seen.insert({index[0], index[1]}).second) throw Error(place + ": this pair stands there twice");
    pairs.push_back({index[0], index[1], {}});
  }
  return pairs;
}

// Pairs by the distance of their frames, so that an image that was left out does not move the others.
std::vector<SourcePair> PairsAtStep(const ImageSource& source, int distance) {
  std::map<int, int> image_of_frame;
  for (std::size_t i = 0; i < source.images.size(); ++i) image_of_frame[source.images[i].frame] = static_cast<int>(i);
  std::vector<SourcePair> pairs;
  for (const auto& [frame, image] : image_of_frame)
    if (const auto other = image_of_frame.find(frame + distance); other != image_of_frame.end())
      pairs.push_back({image, other->second, {}});
  return pairs;
}

}  // namespace

std::vector<std::string> ImagesOfList(const std::string& path) {
  std::vector<std::string> images;
  std::set<std::string> seen;
  const auto is_known = [&](const std::string& name) { return fs::is_regular_file(PathInList(path, name)); };
  for (const ListedPair& pair : ReadListedPairs(path, is_known))
    for (const std::string& name : pair.names)
      if (const std::string image = PathInList(path, name); seen.insert(image).second) images.push_back(image);
  if (images.empty()) throw Error(path + ": it names no images");
  return images;
}

void ChoosePairs(const PairChoice& choice, const std::string& folder, ImageSource* source) {
  if (choice.IsAll()) return;
  if (choice.every < 1) throw Error("--every must be positive");
  if (!choice.steps.empty() && !choice.pairs_file.empty()) throw Error("--steps and --pairs-file exclude each other");
  if (source->scenes.size() != 1 || (!source->scenes[0].pairs.empty() && source->scenes[0].pairs[0].homography))
    throw Error(folder + ": the pairs of this format cannot be chosen");
  const std::string name = source->scenes[0].name;
  std::erase_if(source->images, [&](const SourceImage& image) { return image.frame % choice.every != 0; });
  source->scenes.clear();
  if (!choice.pairs_file.empty()) {
    source->scenes.push_back({name, ReadPairList(choice.pairs_file, *source)});
  } else if (choice.steps.empty()) {
    source->scenes.push_back({name, AllPairs(static_cast<int>(source->images.size()))});
  }
  for (int step : choice.steps) {
    if (step < 1) throw Error("steps: expected positive numbers, found " + std::to_string(step));
    source->scenes.push_back({StepName(name, step), PairsAtStep(*source, step * choice.every)});
  }
  CheckSource(*source, folder);
}

}  // namespace diffsac
