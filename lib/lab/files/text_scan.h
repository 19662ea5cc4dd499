#pragma once

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

}  // namespace diffsac
