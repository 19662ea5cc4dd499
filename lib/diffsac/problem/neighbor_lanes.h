#pragma once

#include "diffsac/problem/nearest_eight.h"

namespace diffsac {

/// Matches whose figures are reckoned together, each in a lane of a vector.
inline constexpr int kLanes = 8;
/// One value a lane; what is done to rows is done to whole vectors.
using LaneRow = float[kLanes];
using LanePlaces = double[kLanes];

/// A longer step counts as this one, whose square single precision holds.
inline constexpr double kFarthestStep = 1e15;

/// Rounded only as a difference; inlined into loops over lanes.
inline float LaneStep(double from, double to) {
  const double step = to - from;
  const double most = step < kFarthestStep ? step : kFarthestStep;
  return static_cast<float>(most > -kFarthestStep ? most : -kFarthestStep);
}

template <class Value>
inline void OrderLanes(Value (&a)[kLanes], Value (&b)[kLanes]) {
  for (int l = 0; l < kLanes; ++l) {
    const Value first = a[l], second = b[l];
    a[l] = first < second ? first : second;
    b[l] = first > second ? first : second;
  }
}

/// Brings the two middle ones of eight to places 3 and 4.
inline void SortMiddle(LaneRow* v) {
  static_assert(kEight == 8);
  OrderLanes(v[0], v[2]), OrderLanes(v[1], v[3]), OrderLanes(v[4], v[6]), OrderLanes(v[5], v[7]);
  OrderLanes(v[0], v[4]), OrderLanes(v[1], v[5]), OrderLanes(v[2], v[6]), OrderLanes(v[3], v[7]);
  OrderLanes(v[0], v[1]), OrderLanes(v[2], v[3]), OrderLanes(v[4], v[5]), OrderLanes(v[6], v[7]);
  OrderLanes(v[2], v[4]), OrderLanes(v[3], v[5]);
  OrderLanes(v[1], v[4]), OrderLanes(v[3], v[6]);
  OrderLanes(v[3], v[4]);
}

}  // namespace diffsac
