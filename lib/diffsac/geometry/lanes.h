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

/// Of four sums, an array or EquationLanes.
template <class Lanes>
double TotalOf(const Lanes& lanes) {
  return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

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

/// Calls add(columns, weights, count) with whole blocks of kEquationLanes points, and with the rest filled up with
/// copies of the last point at weight 0. columns: 4.
template <class Add>
void AddInBlocks(const double* const* columns, const double* weights, int count, const Add& add) {
  constexpr int kLanes = kEquationLanes;
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

// Sums of vectorised terms, for functions compiled for several processors (vector_clones.h): the same on all of them.
// `prepare` and `value` go over the numbers one after the other, so that the compiler puts no branch between their
// choices.

/// Σ w value(prepare(x)) in four running sums: one would make every addition wait for the last. No weights: 1 each.
template <class Prepare, class Value>
[[gnu::always_inline]] inline double SumInLanes(const double* x, const double* weights, int count,
                                                const Prepare& prepare, const Value& value) {
  constexpr int kLanes = kEquationLanes, kChunk = 64;
  alignas(sizeof(EquationLanes)) double terms[kChunk];
  EquationLanes sums = {};
  for (int begin = 0; begin < count; begin += kChunk) {
    const int size = std::min(kChunk, count - begin);
    for (int i = 0; i < size; ++i) terms[i] = prepare(x[begin + i]);
    for (int i = 0; i < size; ++i) terms[i] = value(terms[i]);
    if (weights != nullptr)
      for (int i = 0; i < size; ++i) terms[i] *= weights[begin + i];
    const int whole = size - size % kLanes;
    for (int i = 0; i < whole; i += kLanes) sums += LanesAt(terms + i);
    for (int i = whole; i < size; ++i) sums[0] += terms[i];
  }
  return TotalOf(sums);
}

/// Eight neighbouring floats as one (a vector extension of GCC and Clang), whatever the processor's vectors.
using FloatLanes = float __attribute__((vector_size(8 * sizeof(float)), may_alias));

/// The same of `count` ≤ kMost numbers in single precision, kMost a multiple of 8.
template <int kMost, class Prepare, class Value>
[[gnu::always_inline]] inline float SumFloats(const float* x, const float* weights, int count, const Prepare& prepare,
                                              const Value& value) {
  constexpr int kLanes = 8;
  static_assert(kMost % kLanes == 0);
  alignas(sizeof(FloatLanes)) float terms[kMost];
  for (int i = 0; i < count; ++i) terms[i] = prepare(x[i]);
  for (int i = 0; i < count; ++i) terms[i] = value(terms[i]);
  if (weights != nullptr)
    for (int i = 0; i < count; ++i) terms[i] *= weights[i];
  for (int i = count; i % kLanes != 0; ++i) terms[i] = 0.0f;
  FloatLanes sums = {};
  for (int i = 0; i < count; i += kLanes) sums += *reinterpret_cast<const FloatLanes*>(terms + i);
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

}  // namespace diffsac
