#pragma once

namespace diffsac {

/// Eight neighbouring floats as one (a vector extension of GCC and Clang), whatever the processor's vectors.
using FloatLanes = float __attribute__((vector_size(8 * sizeof(float)), may_alias));

/// Σ w value(prepare(x)) over `count` ≤ kMost numbers, kMost a multiple of 8; no weights: 1 each. For functions
/// compiled for several processors (vector_clones.h): the same sum on all of them. `prepare` and `value` go over the
/// numbers one after the other, so that the compiler puts no branch between their choices.
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
