#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "diffsac/core/files.h"
#include "diffsac/core/status.h"
#include "diffsac/datasets/point_files.h"
#include "diffsac/io/text_scan.h"

namespace diffsac {
namespace {

constexpr std::string_view kSeparators = " \t,;";

// The points read so far; knows the place for messages.
class TextReader {
 public:
  explicit TextReader(const std::string& path) : path_(path) {}

  void ReadLine(std::string_view line) {
    ++line_;
    const auto words = SplitWords(line.substr(0, std::min(line.find('#'), line.size())), kSeparators);
    if (words.empty()) return;
    const bool first = !seen_content_;
    seen_content_ = true;
    double value = 0.0;
    if (first && std::none_of(words.begin(), words.end(), [&](auto word) { return ParseNumber(word, &value); })) return;
    CheckColumns(words.size());
    for (std::string_view word : words) {
      if (!ParseNumber(word, &value)) Fail("expected a number, found '" + std::string(word) + "'");
      values_.push_back(value);
    }
  }

  PointMatrix Points() const {
    if (columns_ == 0) throw Error(path_ + ": no points in this file; expected 2 or 3 numbers a line");
    const auto rows = static_cast<Eigen::Index>(values_.size() / columns_);
    return Eigen::Map<const PointMatrix>(values_.data(), rows, static_cast<Eigen::Index>(columns_));
  }

 private:
  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(path_ + ":" + std::to_string(line_) + ": " + message);
  }

  void CheckColumns(std::size_t count) {
    if (columns_ == 0 && (count < 2 || count > 3)) Fail("expected 2 or 3 columns, found " + std::to_string(count));
    if (columns_ == 0) columns_ = count;
    if (columns_ != count)
      Fail("expected " + std::to_string(columns_) + " columns as in the lines before, found " + std::to_string(count));
  }

  std::string path_;
  int line_ = 0;
  bool seen_content_ = false;
  std::size_t columns_ = 0;
  std::vector<double> values_;
};

}  // namespace

PointSet ReadTextPoints(const std::string& path) {
  const std::string content = ReadFile(path);
  std::string_view rest = content, line;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);  // byte order mark of some spreadsheets
  TextReader reader(path);
  while (TakeLine(&rest, &line)) reader.ReadLine(line);
  const std::filesystem::path file(path);
  PointSet set;
  set.name = file.filename().string();
  set.scene = std::filesystem::absolute(file).parent_path().filename().string();
  set.points = reader.Points();
  return set;
}

}  // namespace diffsac
