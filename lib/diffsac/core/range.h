#pragma once

namespace diffsac {

/// A value, or a closed range to draw from.
struct Range {
  double low = 0.0;
  double high = 0.0;
  Range() = default;
  Range(double value) : low(value), high(value) {}
  Range(double low_value, double high_value) : low(low_value), high(high_value) {}
  bool operator==(const Range&) const = default;
};

}  // namespace diffsac
