#include "lab/files/text_scan.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "diffsac/core/status.h"
#include "lab/files/files.h"

namespace diffsac {

bool ParseNumber(std::string_view word, double* value) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  const auto result = std::from_chars(word.data(), word.data() + word.size(), *value);
  return !word.empty() && result.ec == std::errc() && result.ptr == word.data() + word.size();
}

std::vector<std::string_view> SplitWords(std::string_view line, std::string_view separators) {
  std::vector<std::string_view> words;
  for (;;) {
    const std::size_t start = line.find_first_not_of(separators);
    if (start == std::string_view::npos) return words;
    line.remove_prefix(start);
    const std::size_t end = std::min(line.find_first_of(separators), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

bool TakeLine(std::string_view* text, std::string_view* line) {
  if (text->empty()) return false;
  const std::size_t end = std::min(text->find('\n'), text->size());
  *line = text->substr(0, end);
  text->remove_prefix(std::min(end + 1, text->size()));
  if (line->ends_with('\r')) line->remove_suffix(1);
  return true;
}

std::vector<std::string> TakeCsvLine(const std::string& text, std::size_t* at, char separator) {
  std::vector<std::string> values(1);
  bool quoted = false;
  for (; *at < text.size(); ++*at) {
    const char c = text[*at];
    if (quoted) {
      const bool doubled = c == '"' && *at + 1 < text.size() && text[*at + 1] == '"';
      if (doubled) ++*at;
      if (c == '"' && !doubled)
        quoted = false;
      else
        values.back() += c;
    } else if (c == '\n') {
      ++*at;
      break;
    } else if (c == '"') {
      quoted = true;
    } else if (c == separator) {
      values.emplace_back();
    } else {
      values.back() += c;
    }
  }
  return values;
}

namespace {

std::vector<NumberLine> ReadNumberFile(const std::string& path, std::string_view separators) {
  const std::string text = ReadTextFile(path);
  std::vector<NumberLine> lines;
  std::string_view rest = text, line;
  for (int number = 1; TakeLine(&rest, &line); ++number) {
    const auto words = SplitWords(line, separators);
    if (words.empty() || words[0].starts_with('#')) continue;
    NumberLine parsed{number, std::vector<double>(words.size())};
    for (std::size_t i = 0; i < words.size(); ++i)
      if (!ParseNumber(words[i], &parsed.values[i]))
        throw Error(path + ":" + std::to_string(number) + ": '" + std::string(words[i]) + "' is no number");
    lines.push_back(std::move(parsed));
  }
  return lines;
}

}  // namespace

std::vector<NumberLine> ReadNumberFile(const std::string& path) { return ReadNumberFile(path, " \t"); }

std::vector<NumberLine> ReadNumberFile(const std::string& path, std::size_t count) {
  std::vector<NumberLine> lines = ReadNumberFile(path);
  for (const NumberLine& line : lines)
    if (line.values.size() != count)
      throw Error(path + ":" + std::to_string(line.line) + ": expected " + std::to_string(count) + " numbers, found " +
                  std::to_string(line.values.size()));
  return lines;
}

std::vector<double> ReadNumbersOf(const std::string& path, std::size_t count, const std::string& what) {
  std::vector<double> values;
  for (const NumberLine& line : ReadNumberFile(path, " \t,;[]"))
    values.insert(values.end(), line.values.begin(), line.values.end());
  if (values.size() != count)
    throw Error(path + ": expected " + what + ", found " + std::to_string(values.size()) + " numbers");
  return values;
}

int PixelCount(double value, const std::string& place) {
  if (!(value >= 0.0 && value <= 1e9)) throw Error(place + ": expected the size of an image in pixels");
  return static_cast<int>(value);
}

Eigen::Matrix3d ReadMatrixFile(const std::string& path) {
  return MatrixFromRows(ReadNumbersOf(path, 9, "a 3x3 matrix").data());
}

Eigen::Matrix3d MatrixFromRows(const double* values) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values);
}

}  // namespace diffsac
