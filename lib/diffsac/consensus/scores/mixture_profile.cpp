#include "diffsac/consensus/scores/mixture_profile.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/consensus/scores/mixture.h"

namespace diffsac {
namespace {

constexpr double kReach = 8.0;
constexpr double kTwoPi = 6.28318530717958647693;
/// Expectation maximisation of the share alone for each σ to start from, and of both from the best of them.
constexpr int kStartRounds = 2, kRounds = 30;
constexpr double kTolerance = 1e-3;
/// σ² to start from are so many times one another.
constexpr double kStep = 4.0;

}  // namespace

MixtureProfile::MixtureProfile(double least, double greatest, double extent, int dimension)
    : half_dimension_(0.5 * dimension), reach_(kReach * greatest) {
  least_ = std::pow(std::min(least, greatest) / reach_, 2);
  greatest_ = 1.0 / (kReach * kReach);
  extent_square_ = std::pow(extent / reach_, 2) / kTwoPi;
  for (int b = 0; b < SquareHistogram::kBins; ++b) {
    // The likeliest variance of a residual is its mean square in each dimension.
    const double square = SquareHistogram::Least(b);
    const double variance = std::clamp(0.5 * square / half_dimension_, least_, greatest_);
    most_[b] = std::max(0.0, half_dimension_ * std::log(extent_square_ / variance) - 0.5 * square / variance);
  }
}

double MixtureProfile::Bound(const SquareHistogram& histogram) const {
  double sum = 0.0;
  for (int b = 0; b < SquareHistogram::kBins; ++b) sum += histogram[b].weight * most_[b];
  return sum;
}

double MixtureProfile::operator()(const double* residuals, const double* weights, int count, double bar) const {
  std::vector<double> squares(count);
  const double inverse = 1.0 / reach_;
  for (int i = 0; i < count; ++i) squares[i] = (residuals[i] * inverse) * (residuals[i] * inverse);
  SquareHistogram histogram;
  histogram.Add(squares.data(), weights, count);
  if (Bound(histogram) < bar) return bar;

  Counts counts;
  counts.weights.resize(SquareHistogram::kBins);
  counts.squares.resize(SquareHistogram::kBins);
  counts.total = histogram.total();
  Eigen::Index used = 0;
  for (int b = 0; b < SquareHistogram::kBins; ++b) {
    if (!(histogram[b].weight > 0.0)) continue;
    counts.weights[used] = histogram[b].weight;
    counts.squares[used++] = histogram[b].squares / histogram[b].weight;
  }
  if (used == 0) return 0.0;
  counts.weights.conservativeResize(used);
  counts.squares.conservativeResize(used);
  return Maximise(counts);
}

MixtureProfile::Values MixtureProfile::Ratios(const Counts& counts, double variance) const {
  return (half_dimension_ * std::log(extent_square_ / variance) - (0.5 / variance) * counts.squares).exp();
}

double MixtureProfile::Value(const Counts& counts, const Values& ratios, double share) const {
  const double far = counts.total - counts.weights.sum();
  return (counts.weights * ((1.0 - share) + share * ratios).log()).sum() + far * std::log1p(-share);
}

MixtureProfile::Place MixtureProfile::Start(const Counts& counts) const {
  Place best{0.0, greatest_, 0.0};
  for (double variance = greatest_;; variance = std::max(variance / kStep, least_)) {
    const Values ratios = Ratios(counts, variance);
    double share = ClampShare((counts.weights * (ratios > 1.0).cast<double>()).sum() / counts.total);
    for (int round = 0; round < kStartRounds; ++round)
      share = ClampShare((counts.weights * (share * ratios) / ((1.0 - share) + share * ratios)).sum() / counts.total);
    const double value = Value(counts, ratios, share);
    if (value > best.value) best = {share, variance, value};
    if (!(variance > least_)) return best;
  }
}

double MixtureProfile::Maximise(const Counts& counts) const {
  Place place = Start(counts);
  if (!(place.value > 0.0)) return 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const Values ratios = place.share * Ratios(counts, place.variance);
    const Values inliers = counts.weights * ratios / ((1.0 - place.share) + ratios);
    const double sum = inliers.sum();
    if (!(sum > 0.0)) break;
    const double share = ClampShare(sum / counts.total);
    const double variance =
        std::clamp(0.5 * (inliers * counts.squares).sum() / (half_dimension_ * sum), least_, greatest_);
    const bool settled = std::abs(share - place.share) < kTolerance * share &&
                         std::abs(variance - place.variance) < kTolerance * variance;
    place.share = share;
    place.variance = variance;
    if (settled) break;
  }
  return std::max(place.value, Value(counts, Ratios(counts, place.variance), place.share));
}

}  // namespace diffsac
