#include "diffsac/consensus/marginal_likelihood.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace diffsac {
namespace {

constexpr double kLogTwo = 0.693147180559945309417, kLogTwoPi = 1.83787706640934548356;
/// Squares that are all 0 add up to as much as one residual of a millionth of a.
constexpr double kLeastScale = 0.5e-12;

/// log Γ(z), z > 0, to 1e-10: Stirling's series, from 10 on. (std::lgamma is slower, and writes to a global.)
double LogGamma(double z) {
  double product = 1.0;
  for (; z < 10.0; z += 1.0) product *= z;
  const double inverse = 1.0 / z, square = inverse * inverse;
  const double series = inverse * (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0)));
  return (z - 0.5) * std::log(z) - z + 0.5 * kLogTwoPi + series - (product == 1.0 ? 0.0 : std::log(product));
}

}  // namespace

MarginalLikelihood::MarginalLikelihood(double half_width, int dimension, int free, double prior, double sigma)
    : inverse_half_width_(1.0 / half_width),
      half_dimension_(0.5 * dimension),
      free_(free),
      shape_(prior * half_dimension_),
      scale_(shape_ * std::pow(sigma / half_width, 2) + kLeastScale),
      constant_(shape_ > 0.0 ? shape_ * std::log(scale_) - LogGamma(shape_) : 0.0) {}

double MarginalLikelihood::Value(double weight, double squares) const {
  const double half_dof = (weight - free_) * half_dimension_, z = shape_ + half_dof;
  return LogGamma(z) - z * std::log(scale_ + 0.5 * squares) - half_dof * kLogTwoPi +
         2.0 * weight * half_dimension_ * kLogTwo + constant_;
}

double MarginalLikelihood::BinBound(const Bin& before, const Bin& bin, double least) const {
  const double first = free_ + 1.0;
  double bound = Value(before.weight + bin.weight, before.squares + bin.weight * least);
  // Where the first number of inliers that counts is inside the bin.
  if (before.weight < first) bound = std::max(bound, Value(first, before.squares + (first - before.weight) * least));
  return bound;
}

MarginalLikelihood::Sweep MarginalLikelihood::SweepBins(const SquareHistogram& histogram) const {
  Sweep sweep;
  Bin sum;
  for (int b = 0; b < SquareHistogram::kBins; ++b) {
    sweep.before[b] = sum;
    const Bin& bin = histogram[b];
    if (!(bin.weight > 0.0)) continue;
    if (sum.weight + bin.weight >= free_ + 1.0) {
      sweep.bounds[b] = BinBound(sum, bin, SquareHistogram::Least(b));
      sweep.best = std::max(sweep.best, Value(sum.weight + bin.weight, sum.squares + bin.squares));
      sweep.bound = std::max(sweep.bound, sweep.bounds[b]);
    }
    sum = {sum.weight + bin.weight, sum.squares + bin.squares};
  }
  return sweep;
}

double MarginalLikelihood::Bound(const SquareHistogram& histogram) const { return SweepBins(histogram).bound; }

double MarginalLikelihood::operator()(const double* residuals, const double* weights, int count, double bar) const {
  std::vector<double> squares(count);
  for (int i = 0; i < count; ++i) {
    const double share = residuals[i] * inverse_half_width_;
    squares[i] = share * share;
  }
  SquareHistogram histogram;
  histogram.Add(squares.data(), weights, count);
  const Sweep sweep = SweepBins(histogram);
  if (sweep.bound < bar) return bar;

  std::vector<std::pair<double, double>> inside;  // Square and weight.
  for (int i = 0; i < count; ++i)
    if (squares[i] < 1.0 && sweep.bounds[SquareHistogram::BinOf(squares[i])] > sweep.best)
      inside.emplace_back(squares[i], weights == nullptr ? 1.0 : weights[i]);
  std::sort(inside.begin(), inside.end());
  double best = sweep.best;
  Bin sum;
  int last = -1;
  for (const auto& [square, weight] : inside) {
    const int bin = SquareHistogram::BinOf(square);
    if (bin != last) sum = sweep.before[bin];
    last = bin;
    sum = {sum.weight + weight, sum.squares + weight * square};
    if (sum.weight >= free_ + 1.0) best = std::max(best, Value(sum.weight, sum.squares));
  }
  return best;
}

}  // namespace diffsac
