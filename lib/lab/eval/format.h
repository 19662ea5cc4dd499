#pragma once

#include <charconv>
#include <cmath>
#include <cstdio>
#include <string>

namespace diffsac {

/// snprintf as a text of at most 159 characters.
template <class... Values>
std::string Format(const char* format, Values... values) {
  char text[160];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

/// "0.512": with so many digits behind the point, or, where that would be a long row of digits, "1.5e+300".
inline std::string FixedNumber(double value, int digits) {
  constexpr double kLong = 1e9;
  return std::abs(value) < kLong ? Format("%.*f", digits, value) : Format("%.3g", value);
}

/// As short as reads back to the same number.
inline std::string ShortestNumber(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof(text), value).ptr};
}

/// A number as files have it, with nine digits; empty where it is unknown or not finite.
inline std::string NumberText(double value) { return std::isfinite(value) ? Format("%.9g", value) : ""; }

/// A field of a CSV file, quoted only when it must be (RFC 4180).
inline std::string CsvText(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace diffsac
