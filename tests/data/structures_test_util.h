#pragma once

#include <algorithm>
#include <vector>

#include "diffsac/data/problem.h"

namespace diffsac {

/// Points of each structure, by the labels.
inline std::vector<int> StructureSizes(const Example& example) {
  std::vector<int> sizes(example.truth.structures.size(), 0);
  for (const std::int32_t label : example.truth.labels)
    if (label > 0) ++sizes.at(label - 1);
  return sizes;
}

inline int CountLabelled(const Example& example) {
  return static_cast<int>(
      std::count_if(example.truth.labels.begin(), example.truth.labels.end(), [](int label) { return label > 0; }));
}

}  // namespace diffsac
