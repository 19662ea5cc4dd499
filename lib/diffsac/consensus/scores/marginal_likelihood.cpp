#include "diffsac/consensus/scores/marginal_likelihood.h"

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
    : half_width_(half_width),
      inverse_half_width_(1.0 / half_width),
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

void MarginalLikelihood::SweepBins(const SquareHistogram& histogram, Sweep* sweep) const {
  const double first = free_ + 1.0;
  Values weights(SquareHistogram::kBins), squares(SquareHistogram::kBins);
  double crossing = 0.0;
  Bin sum;
  int size = 0;
  for (int b = 0; b < SquareHistogram::kBins; ++b) {
    const Bin& bin = histogram[b];
    if (!(bin.weight > 0.0)) continue;
    if (sum.weight + bin.weight >= first) {
      const double least = SquareHistogram::Least(b);
      // The first number of inliers that counts is inside this bin.
      if (size == 0) crossing = Value(first, sum.squares + (first - sum.weight) * least);
      sweep->bins[size] = b;
      sweep->before[size] = sum;
      weights[size] = sum.weight + bin.weight;
      squares[size++] = sum.squares + bin.weight * least;
    }
    sum = {sum.weight + bin.weight, sum.squares + bin.squares};
  }
  sweep->size = size;
  // Value for all, with what Stirling's series has at most.
  const auto half_dof = (weights.head(size) - free_) * half_dimension_;
  const Values z = shape_ + half_dof;
  sweep->bounds = z * (z / (scale_ + 0.5 * squares.head(size))).log() - z - 0.5 * z.log() + 1.0 / (12.0 * z) -
                  half_dof * kLogTwoPi + weights.head(size) * (2.0 * half_dimension_ * kLogTwo) +
                  (constant_ + 0.5 * kLogTwoPi);
  if (size > 0) sweep->bounds[0] = std::max(sweep->bounds[0], crossing);
}

double MarginalLikelihood::BoundOfAll(const SquareHistogram& histogram) const {
  Sweep sweep;
  SweepBins(histogram, &sweep);
  return sweep.size == 0 ? 0.0 : std::max(0.0, sweep.bounds.maxCoeff());
}

double MarginalLikelihood::OfAll(const double* residuals, const double* weights, int count, double bar) const {
  std::vector<double> squares(count);
  for (int i = 0; i < count; ++i) {
    const double share = residuals[i] * inverse_half_width_;
    squares[i] = share * share;
  }
  SquareHistogram histogram;
  histogram.Add(squares.data(), weights, count);
  Sweep sweep;
  SweepBins(histogram, &sweep);
  if (sweep.size == 0) return 0.0;
  return sweep.bounds.maxCoeff() < bar ? bar : BestInside(histogram, sweep, squares, weights);
}

double MarginalLikelihood::BestInside(const SquareHistogram& histogram, const Sweep& sweep,
                                      const std::vector<double>& squares, const double* weights) const {
  double best = 0.0;
  Eigen::Index likeliest = 0;
  sweep.bounds.maxCoeff(&likeliest);
  const auto at_end = [&](Eigen::Index k) {
    const Bin &before = sweep.before[k], &bin = histogram[sweep.bins[k]];
    best = std::max(best, Value(before.weight + bin.weight, before.squares + bin.squares));
  };
  at_end(likeliest);
  for (int k = 0; k < sweep.size; ++k)
    if (sweep.bounds[k] > best) at_end(k);

  // Which of the bins are looked into; −1: none.
  std::array<int, SquareHistogram::kBins> place;
  place.fill(-1);
  for (int k = 0; k < sweep.size; ++k)
    if (sweep.bounds[k] > best) place[sweep.bins[k]] = k;
  std::vector<std::pair<double, double>> inside;  // Square and weight.
  for (std::size_t i = 0; i < squares.size(); ++i)
    if (squares[i] < 1.0 && place[SquareHistogram::BinOf(squares[i])] >= 0)
      inside.emplace_back(squares[i], weights == nullptr ? 1.0 : weights[i]);
  std::sort(inside.begin(), inside.end());
  Bin sum;
  int last = -1;
  for (const auto& [square, weight] : inside) {
    const int k = place[SquareHistogram::BinOf(square)];
    if (k != last) sum = sweep.before[k];
    last = k;
    sum = {sum.weight + weight, sum.squares + weight * square};
    if (sum.weight >= free_ + 1.0) best = std::max(best, Value(sum.weight, sum.squares));
  }
  return best;
}

}  // namespace diffsac
