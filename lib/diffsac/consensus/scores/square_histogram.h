#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace diffsac {

/// Squared residuals by their size: four bins an octave of r², 24 octaves below the square of the unit, and one more
/// octave's worth for all that is smaller. Scores that look at all residuals at once go over its bins instead of over
/// sorted points. Weights are those of the points, 1 each where there are none.
class SquareHistogram {
 public:
  static constexpr int kBins = 96;

  /// What the points in a bin add up to.
  struct Bin {
    double weight = 0.0;   ///< Σ w
    double squares = 0.0;  ///< Σ w r², in squares of the unit.
  };

  /// The bin of a square below 1; what bounds make less than 0 is in the first.
  static int BinOf(double square) {
    if (!(square > 0.0)) return 0;
    return std::max(0, static_cast<int>(std::bit_cast<std::uint64_t>(square) >> kShift) - kFirst);
  }
  /// No square in the bin is smaller.
  static double Least(int bin) {
    return bin == 0 ? 0.0 : std::bit_cast<double>(static_cast<std::uint64_t>(bin + kFirst) << kShift);
  }

  /// Counts `count` squared residuals, in squares of the unit; those from 1 on, and what is not a number, count in
  /// total() alone. No weights: 1 each.
  template <class Real>
  void Add(const Real* squares, const Real* weights, int count) {
    for (int i = 0; i < count; ++i) {
      const double square = squares[i];
      if (!(square < 1.0)) continue;
      const double weight = weights == nullptr ? 1.0 : static_cast<double>(weights[i]);
      Bin& bin = bins_[BinOf(square)];
      bin.weight += weight;
      bin.squares += weight * square;
    }
    total_ +=
        weights == nullptr
            ? count
            : Eigen::Map<const Eigen::Array<Real, Eigen::Dynamic, 1>>(weights, count).template cast<double>().sum();
  }

  const Bin& operator[](int bin) const { return bins_[bin]; }
  /// Σ w of all that was added.
  double total() const { return total_; }

 private:
  /// Leaves the exponent and two bits of a double's mantissa.
  static constexpr int kShift = 50;
  static constexpr int kFirst = static_cast<int>(std::bit_cast<std::uint64_t>(1.0) >> kShift) - kBins;

  std::array<Bin, kBins> bins_{};
  double total_ = 0.0;
};

}  // namespace diffsac
