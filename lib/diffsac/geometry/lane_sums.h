#pragma once

#include <algorithm>

namespace diffsac {

// Sums of vectorised terms, for functions compiled for several processors (vector_clones.h): the same on all of them.
// `prepare` and `value` go over the numbers one after the other, so that the compiler puts no branch between their
// choices.

/// Σ w value(prepare(x)) in four running sums: one would make every addition wait for the last. No weights: 1 each.
template <class Prepare, class Value>
[[gnu::always_inline]] inline double SumInLanes(const double* x, const double* weights, int count,
                                                const Prepare& prepare, const Value& value) {
  constexpr int kLanes = 4, kChunk = 64;
  using Lanes = double __attribute__((vector_size(kLanes * sizeof(double)), may_alias));
  alignas(sizeof(Lanes)) double terms[kChunk];
  Lanes sums = {};
  for (int begin = 0; begin < count; begin += kChunk) {
    const int size = std::min(kChunk, count - begin);
    for (int i = 0; i < size; ++i) terms[i] = prepare(x[begin + i]);
    for (int i = 0; i < size; ++i) terms[i] = value(terms[i]);
    if (weights != nullptr)
      for (int i = 0; i < size; ++i) terms[i] *= weights[begin + i];
    const int whole = size - size % kLanes;
    for (int i = 0; i < whole; i += kLanes) sums += *reinterpret_cast<const Lanes*>(terms + i);
    for (int i = whole; i < size; ++i) sums[0] += terms[i];
  }
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
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
