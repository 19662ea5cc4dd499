#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>

namespace diffsac::testing {

/// Reads choices and numbers from an input's bytes; zeros once they have run out.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  std::uint8_t Byte() { return at_ < bytes_.size() ? static_cast<std::uint8_t>(bytes_[at_++]) : 0; }
  bool Flag() { return (Byte() & 1) != 0; }
  /// In [0, n).
  int Below(int n) { return Byte() % n; }

  std::uint64_t Word() {
    std::uint64_t word = 0;
    for (int i = 0; i < 8; ++i) word = word << 8 | Byte();
    return word;
  }

  /// Any double: small integers, fractions, awkward values, or any bits.
  double Number() {
    constexpr double kAwkward[] = {0.0,
                                   -0.0,
                                   1.0,
                                   -1.0,
                                   std::numeric_limits<double>::quiet_NaN(),
                                   std::numeric_limits<double>::infinity(),
                                   -std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::denorm_min(),
                                   std::numeric_limits<double>::min(),
                                   std::numeric_limits<double>::max(),
                                   std::numeric_limits<double>::lowest(),
                                   std::numeric_limits<double>::epsilon(),
                                   1e8,
                                   1e-8,
                                   1e154,
                                   1e-154};
    const std::uint8_t kind = Byte();
    if (kind < 160) return static_cast<std::int8_t>(Byte());
    if (kind < 224) return (Byte() * 256 + Byte()) / 64.0;
    if (kind < 240) return kAwkward[Below(16)];
    const std::uint64_t word = Word();
    double number;
    std::memcpy(&number, &word, sizeof number);
    return number;
  }

  /// A positive number, within [1e-300, 1e300]; mostly of order one.
  double Positive() {
    const std::uint8_t kind = Byte();
    if (kind < 224) return (1 + Byte()) / 32.0;
    const double number = std::abs(Number());
    return number >= 1e-300 && number <= 1e300 ? number : 1.0;
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace diffsac::testing
