#include "fuzz/fuzz_target.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace diffsac::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 24;
constexpr std::string_view kBefore = "==> ", kAfter = " <==";

// A grey PGM of 10 x 8 pixels: readers tell the format by the content.
const std::string& SmallImage() {
  static const std::string image = "P5\n10 8\n255\n" + std::string(80, '\x40');
  return image;
}

class ScratchFolder {
 public:
  ScratchFolder() {
    const char* memory = "/dev/shm";
    const bool has_memory = ::access(memory, W_OK) == 0;
    const fs::path parent = has_memory ? fs::path(memory) : fs::temp_directory_path();
    path_ = (parent / ("diffsac-fuzz-" + std::to_string(::getpid()))).string();
    fs::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code code;
    fs::remove_all(path_, code);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

bool IsPlainPath(const std::string& name) {
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '.' || c == '-' || c == '/';
  });
  return plain && !name.empty() && name.size() <= 64 && name[0] != '/' && name.back() != '/' &&
         name.find("..") == std::string::npos && name.find("//") == std::string::npos;
}

std::string ReadWhole(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return std::string((std::istreambuf_iterator<char>(file)), {});
}

}  // namespace

void Require(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: broken promise: %s\n", what.c_str());
  std::abort();
}

void Note(const std::string& message) {
  static const bool verbose = std::getenv("DIFFSAC_FUZZ_VERBOSE") != nullptr;
  if (verbose) std::fprintf(stderr, "fuzz: %s\n", message.c_str());
}

std::vector<std::string> FilesBelow(const std::string& folder, const std::string& ending, std::size_t largest) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().string().ends_with(ending) && entry.file_size() <= largest)
      paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<std::string> contents;
  for (const fs::path& path : paths) contents.push_back(ReadWhole(path));
  return contents;
}

std::map<std::string, FuzzTarget>& FuzzTargets() {
  static std::map<std::string, FuzzTarget> targets;
  return targets;
}

std::vector<std::string> SeedsIn(const std::string& name) {
  constexpr std::string_view kBetween = "\n==== seed\n";
  std::string rest = ReadWhole(fs::path(DIFFSAC_SOURCE_DIR) / "tests/fuzz/seeds" / name);
  Require(!rest.empty(), "there are seeds of " + name);
  std::vector<std::string> seeds;
  for (std::size_t end; (end = rest.find(kBetween)) != std::string::npos; rest.erase(0, end + kBetween.size()))
    seeds.push_back(rest.substr(0, end));
  seeds.push_back(rest);
  return seeds;
}

const std::string& Scratch() {
  static const ScratchFolder folder;
  return folder.path();
}

std::string WriteScratch(const std::string& name, std::string_view content) {
  const fs::path path = fs::path(Scratch()) / name;
  std::error_code code;
  fs::create_directories(path.parent_path(), code);
  std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
  return path.string();
}

const std::string* Bundle::Find(const std::string& name) const {
  for (const File& file : files)
    if (file.name == name) return &file.content;
  return nullptr;
}

Bundle ParseBundle(std::string_view text) {
  Bundle bundle;
  const std::size_t first = std::min(text.find('\n'), text.size());
  bundle.kind = text.substr(0, first);
  text.remove_prefix(std::min(first + 1, text.size()));
  while (text.starts_with(kBefore) && bundle.files.size() < kMostFiles) {
    const std::size_t line = std::min(text.find('\n'), text.size());
    std::string name(text.substr(kBefore.size(), line - kBefore.size()));
    if (name.ends_with(kAfter)) name.resize(name.size() - kAfter.size());
    text.remove_prefix(std::min(line + 1, text.size()));
    const std::size_t next = text.starts_with(kBefore) ? 0 : text.find("\n" + std::string(kBefore));
    const std::size_t size = next == std::string_view::npos ? text.size() : next + (next > 0 ? 1 : 0);
    if (IsPlainPath(name)) bundle.files.push_back({name, std::string(text.substr(0, size))});
    text.remove_prefix(size);
  }
  return bundle;
}

std::string BundleText(const Bundle& bundle) {
  std::string text = bundle.kind + "\n";
  for (const Bundle::File& file : bundle.files) {
    text += std::string(kBefore) + file.name + std::string(kAfter) + "\n" + file.content;
    if (!file.content.ends_with('\n')) text += "\n";
  }
  return text;
}

void WriteBundle(const Bundle& bundle) {
  for (const auto& entry : fs::directory_iterator(Scratch())) fs::remove_all(entry.path());
  for (const Bundle::File& file : bundle.files) {
    const bool image = file.content == "image" || file.content == "image\n";
    WriteScratch(file.name, image ? SmallImage() : file.content);
  }
}

}  // namespace diffsac::testing
