#pragma once

#include <algorithm>

namespace diffsac {

/// Calls add(columns, weights, count) with whole blocks of kLanes points, and with the rest filled up with copies of
/// the last point at weight 0. columns: 4.
template <int kLanes, class Add>
void AddInBlocks(const double* const* columns, const double* weights, int count, const Add& add) {
  const int whole = count - count % kLanes;
  add(columns, weights, whole);
  if (whole == count) return;
  double rest[4][kLanes], rest_weights[kLanes] = {};
  for (int l = 0; l < kLanes; ++l) {
    const int row = std::min(whole + l, count - 1);
    for (int i = 0; i < 4; ++i) rest[i][l] = columns[i][row];
    if (whole + l < count) rest_weights[l] = weights[row];
  }
  const double* rest_columns[4] = {rest[0], rest[1], rest[2], rest[3]};
  add(rest_columns, rest_weights, kLanes);
}

}  // namespace diffsac
