#pragma once

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

/// A field of a CSV file, quoted only when it must be (RFC 4180).
inline std::string CsvText(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace diffsac
