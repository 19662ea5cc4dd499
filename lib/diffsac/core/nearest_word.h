#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// The candidate with the smallest edit distance to `word`, the first of equals, for "did you mean"; empty when there
/// is none.
std::string NearestWord(const std::string& word, const std::vector<std::string>& candidates);

/// "a, b or c" for messages; names must not be empty.
std::string OneOf(const std::vector<std::string>& names);

}  // namespace diffsac
