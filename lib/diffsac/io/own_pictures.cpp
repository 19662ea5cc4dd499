#include "diffsac/io/own_pictures.h"

#include <filesystem>
#include <fstream>

#include "diffsac/core/logging.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr std::string_view kMark = "\ndrawn by DiffSAC, no photograph\n";

}  // namespace

std::string MarkedAsOwn(std::string_view picture) { return std::string(picture) + std::string(kMark); }

bool IsOwnPicture(const std::string& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return false;
  std::ifstream file(path, std::ios::binary);
  file.seekg(-static_cast<std::streamoff>(kMark.size()), std::ios::end);
  std::string end(kMark.size(), '\0');
  return file.read(end.data(), static_cast<std::streamsize>(end.size())) && end == kMark;
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
