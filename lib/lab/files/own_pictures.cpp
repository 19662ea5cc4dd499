#include "lab/files/own_pictures.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

using std::string_view_literals::operator""sv;

/// Of PNG a chunk of text, with its length and checksum, before the last chunk; of other formats what follows the end.
constexpr std::string_view kPngStart = "\x89PNG"sv;
constexpr std::string_view kChunk = "\0\0\0\x28tEXtSoftware\0drawn by DiffSAC, no photograph\xed\x88\x17\xcf"sv;
constexpr std::string_view kPngEnd = "\0\0\0\0IEND\xae\x42\x60\x82"sv;
constexpr std::string_view kMark = "\ndrawn by DiffSAC, no photograph\n"sv;

}  // namespace

std::string MarkedAsOwn(std::string_view picture) {
  if (!picture.starts_with(kPngStart) || !picture.ends_with(kPngEnd)) return std::string(picture) + std::string(kMark);
  picture.remove_suffix(kPngEnd.size());
  return std::string(picture) + std::string(kChunk) + std::string(kPngEnd);
}

bool IsOwnPicture(const std::string& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return false;
  const auto size = std::min<std::uintmax_t>(std::filesystem::file_size(path, code), kChunk.size() + kPngEnd.size());
  std::ifstream file(path, std::ios::binary);
  file.seekg(-static_cast<std::streamoff>(size), std::ios::end);
  std::string end(size, '\0');
  if (code || !file.read(end.data(), static_cast<std::streamsize>(size))) return false;
  return end.ends_with(kMark) || end == std::string(kChunk) + std::string(kPngEnd);
}

bool PassOverOwnPicture(const std::string& path) {
  const bool own = IsOwnPicture(path);
  if (own) LogWarning("left out: " + path + ": drawn by DiffSAC, no photograph");
  return own;
}

void RefuseOtherPicture(const std::string& path) {
  std::error_code code;
  if (std::filesystem::is_regular_file(path, code) && !IsOwnPicture(path))
    throw Error("'" + path +
                "' is there already, and is no picture that DiffSAC drew: give another name, or remove it");
}

}  // namespace diffsac
