#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace diffsac {

/// A number in any usual notation, "nan", "inf" and a leading "+" included; false unless all of `word` is one.
bool ParseNumber(std::string_view word, double* value);

/// The words of a line between any of `separators`.
std::vector<std::string_view> SplitWords(std::string_view line, std::string_view separators);

/// Cuts the first line off `text` (without its "\n" or "\r\n"); false at the end.
bool TakeLine(std::string_view* text, std::string_view* line);

/// Takes one line of a CSV file off `text` from *at on: its values, without quotes. A value in quotes may hold
/// separators, line ends and doubled quotes.
std::vector<std::string> TakeCsvLine(const std::string& text, std::size_t* at, char separator = ',');

/// One line of a text file with numbers.
struct NumberLine {
  int line = 0;  ///< Its number, from 1, for messages.
  std::vector<double> values;
};

/// Lines of blank-separated numbers; empty lines and those that start with `#` are skipped. Throws Error with file and
/// line for anything else.
std::vector<NumberLine> ReadNumberFile(const std::string& path);

/// The same, and every line must have `count` numbers.
std::vector<NumberLine> ReadNumberFile(const std::string& path, std::size_t count);

/// All numbers of a file that must hold `count`, with commas, semicolons and square brackets between them or without;
/// `what` says in messages what they are ("a 4x4 matrix").
std::vector<double> ReadNumbersOf(const std::string& path, std::size_t count, const std::string& what);

/// A number of pixels, as an int. Throws Error, starting with `place`, unless it is from 0 to 10^9.
int PixelCount(double value, const std::string& place);

/// A file that holds exactly a 3 × 3 matrix, row by row, in any number of lines.
Eigen::Matrix3d ReadMatrixFile(const std::string& path);

/// The nine numbers from `values`, row by row.
Eigen::Matrix3d MatrixFromRows(const double* values);

}  // namespace diffsac
