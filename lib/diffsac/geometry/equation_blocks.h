#pragma once

#include <algorithm>

namespace diffsac {

// What the sums of normal equations share: terms of a block of points are worked out as columns, few enough for the
// first cache, and then each row of sums stays in registers while the block goes by.

inline constexpr int kEquationLanes = 4;
inline constexpr int kEquationBlock = 32;

/// Four neighbouring numbers as one (a vector extension of GCC and Clang), whatever the processor's vectors, so that
/// sums are the same everywhere.
using EquationLanes = double __attribute__((vector_size(kEquationLanes * sizeof(double)), may_alias));

/// One value of each point of a block.
using EquationColumn = double[kEquationBlock];

inline const EquationLanes& LanesAt(const double* values) { return *reinterpret_cast<const EquationLanes*>(values); }

inline double TotalOf(const EquationLanes& lanes) { return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]); }

/// sums[j] += Σ left · right[j] for kCount columns of `size` values, a multiple of four.
template <int kCount>
[[gnu::always_inline]] inline void AddProducts(const EquationColumn& left, const EquationColumn* right, int size,
                                               EquationLanes* sums) {
  EquationLanes row[kCount] = {};
  for (int i = 0; i < size; i += kEquationLanes) {
    const EquationLanes factor = LanesAt(left + i);
    for (int j = 0; j < kCount; ++j) row[j] += factor * LanesAt(right[j] + i);
  }
  for (int j = 0; j < kCount; ++j) sums[j] += row[j];
}

}  // namespace diffsac
