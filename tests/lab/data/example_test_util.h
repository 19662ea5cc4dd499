#pragma once

#include <algorithm>
#include <vector>

#include "lab/ground_truth/example.h"

namespace diffsac {

/// Points of each structure, by the labels.
inline std::vector<int> InstanceSizes(const Example& example) {
  std::vector<int> sizes(example.truth.instances.size(), 0);
  for (const std::int32_t label : example.truth.assignment)
    if (label > 0) ++sizes.at(label - 1);
  return sizes;
}

inline int CountInliers(const Example& example) {
  return static_cast<int>(std::count(example.truth.inliers.begin(), example.truth.inliers.end(), 1));
}

inline int CountLabelled(const Example& example) {
  return static_cast<int>(std::count_if(example.truth.assignment.begin(), example.truth.assignment.end(),
                                        [](int label) { return label > 0; }));
}

namespace testing {

/// Eigen compares only what is of the same size.
inline bool SamePoints(const PointMatrix& a, const PointMatrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && a == b;
}

}  // namespace testing

}  // namespace diffsac
