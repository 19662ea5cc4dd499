#pragma once

#include <string>
#include <vector>

namespace diffsac {

/// The candidate with the smallest edit distance to `word`, the first of equals, for "did you mean"; empty when there
/// is none.
std::string NearestWord(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace diffsac
