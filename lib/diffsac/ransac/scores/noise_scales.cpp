#include "diffsac/ransac/scores/noise_scales.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace diffsac {
namespace {

/// Leaves the exponent and one bit of a double's mantissa.
constexpr int kShift = 51;
constexpr int kShareRounds = 2;
constexpr double kSqrtTwoPi = 2.50662827463100050242;

int SizeOf(double square) { return static_cast<int>(std::bit_cast<std::uint64_t>(square) >> kShift); }

/// Of the middle of a bin, in units of the greatest threshold's.
double SquareOf(int bin) { return std::ldexp(bin % 2 == 0 ? 0.875 : 0.625, -(bin / 2)); }

/// Where a parabola through values at −1, 0 and 1, the middle one the largest, is largest.
double Peak(double left, double middle, double right) {
  const double bend = left - 2.0 * middle + right;
  return bend < 0.0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0.0;
}

}  // namespace

NoiseEstimator::NoiseEstimator(const ThresholdRange& range, int free) : range_(range), free_(free), steps_(1) {
  if (!(range.least < range.greatest)) return;
  const double octaves = std::log2(range.greatest / range.least);
  steps_ = static_cast<int>(std::clamp(std::round(2.0 * octaves), 0.0, kMaxThresholds - 1.0)) + 1;
  for (int k = 0; k < steps_; ++k) {
    const double sigma = std::exp2(-0.5 * k) / kSigmasOfInlier;
    const double density = std::max(2.0, range.extent / range.greatest / (kSqrtTwoPi * sigma));
    for (int b = 0; b < kBins; ++b) ratios_[k][b] = density * std::exp(-0.5 * SquareOf(b) / (sigma * sigma));
  }
}

NoiseEstimator::Counts NoiseEstimator::Count(const double* residuals, int count) const {
  Counts counts = Counts::Zero();
  const double factor = 1.0 / (range_.greatest * range_.greatest);
  const int largest = SizeOf(0.75);
  for (int i = 0; i < count; ++i) {
    const double square = residuals[i] * residuals[i] * factor;
    if (square < 1.0) counts[std::min(largest - SizeOf(square), kBins - 1)] += 1.0;
  }
  double left = free_;
  for (int b = kBins - 1; b >= 0 && left > 0.0; --b) {
    const double dropped = std::min(left, counts[b]);
    counts[b] -= dropped;
    left -= dropped;
  }
  return counts;
}

double NoiseEstimator::LogLikelihood(const Counts& counts, double total, int step) const {
  const Counts& ratios = ratios_[step];
  // Those within the threshold, then expectation maximisation.
  double share = counts.tail(kBins - 2 * step).sum() / total;
  for (int round = 0; round < kShareRounds; ++round) {
    share = ClampShare(share);
    share = (counts * (share * ratios) / ((1.0 - share) + share * ratios)).sum() / total;
  }
  share = ClampShare(share);
  return (counts * ((1.0 - share) + share * ratios).log()).sum() + (total - counts.sum()) * std::log1p(-share);
}

double NoiseEstimator::Threshold(const double* residuals, int count) const {
  if (steps_ == 1) return range_.greatest;
  const Counts counts = Count(residuals, count);
  if (!(counts.sum() > 0.0)) return range_.greatest;
  std::array<double, kMaxThresholds> values{};
  int best = 0;
  for (int k = 0; k < steps_; ++k) {
    values[k] = LogLikelihood(counts, std::max(1, count - free_), k);
    if (values[k] > values[best]) best = k;
  }
  const bool inside = best > 0 && best < steps_ - 1;
  const double place = best + (inside ? Peak(values[best - 1], values[best], values[best + 1]) : 0.0);
  return range_.greatest * std::exp2(-0.5 * place);
}

}  // namespace diffsac
