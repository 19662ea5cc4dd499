#include "lab/files/text_scan.h"

#include <algorithm>
#include <charconv>
#include <system_error>

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

}  // namespace diffsac
