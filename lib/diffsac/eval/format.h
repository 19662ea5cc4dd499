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

}  // namespace diffsac
