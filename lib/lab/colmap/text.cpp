#include "lab/colmap/text.h"

#include <cmath>
#include <filesystem>

#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"

namespace diffsac {

namespace fs = std::filesystem;

ColmapLines::ColmapLines(const std::string& path) : path_(path), text_(ReadTextFile(path)), rest_(text_) {}

bool ColmapLines::Next() {
  while (TakeLine(&rest_, &line_)) {
    ++number_;
    if (!line_.starts_with('#')) return true;
  }
  return false;
}

std::vector<std::string_view> ColmapLines::Words() const { return SplitWords(line_, " \t"); }

std::string ColmapLines::After(std::size_t words) const {
  const auto all = Words();
  if (all.size() <= words) return "";
  return {all[words].data(), static_cast<std::size_t>(all.back().data() + all.back().size() - all[words].data())};
}

std::string ColmapLines::Place() const { return path_ + ":" + std::to_string(number_); }

void ColmapLines::Fail(const std::string& what) const { throw Error(Place() + ": " + what); }

double ColmapLines::Number(std::string_view word) const {
  double value = 0.0;
  if (!ParseNumber(word, &value)) Fail("'" + std::string(word) + "' is no number");
  return value;
}

std::int64_t ColmapLines::Whole(std::string_view word) const {
  const double value = Number(word);
  if (!(std::abs(value) <= 0x1p53) || value != std::floor(value))
    Fail("'" + std::string(word) + "' is no whole number");
  return static_cast<std::int64_t>(value);
}

std::string FindColmapModel(const std::string& folder, const std::string& extension) {
  for (const char* name : {"", "colmap_ground_truth", "sparse/0", "sparse"}) {
    const fs::path candidate = fs::path(folder) / name;
    if (fs::exists(candidate / ("cameras" + extension)) && fs::exists(candidate / ("images" + extension)))
      return candidate.string();
  }
  return "";
}

std::string ColmapModelFolder(const std::string& folder) {
  const std::string found = FindColmapModel(folder, ".txt");
  if (found.empty()) throw Error(folder + ": no COLMAP text model (cameras.txt, images.txt)");
  return found;
}

}  // namespace diffsac
