#include "lab/files/number_file.h"

#include <string_view>

#include "diffsac/core/status.h"
#include "lab/files/files.h"
#include "lab/files/text_scan.h"

namespace diffsac {

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
