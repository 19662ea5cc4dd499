#include "diffsac/consensus/score.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "diffsac/consensus/magsac.h"

namespace diffsac {

namespace {

/// Of kScales: the smallest scale, as a share of ε. At the second all scales are one, and the score is MSAC.
constexpr double kLeastShare = 1e-3, kLargestShare = 0.99;

double Cube(double x) { return x * x * x; }

/// Four running sums of values: one would make every addition wait for the last.
template <class Value>
double SumInLanes(int count, const Value& value) {
  double sums[4] = {0.0, 0.0, 0.0, 0.0};
  int i = 0;
  for (; i + 4 <= count; i += 4)
    for (int lane = 0; lane < 4; ++lane) sums[lane] += value(i + lane);
  for (; i < count; ++i) sums[0] += value(i);
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace

Score::Score(ScoreKind kind, double threshold, double sigma, double odds, int residual_dof, double least)
    : kind_(kind),
      threshold_(threshold),
      inverse_threshold_squared_(1.0 / (threshold * threshold)),
      half_inverse_variance_(0.5 / (sigma * sigma)),
      odds_(odds),
      inverse_log_(1.0 / std::log1p(odds)),
      residual_dof_(residual_dof),
      table_(kind == ScoreKind::kMagsac ? MagsacScoreTable(residual_dof) : nullptr),
      table_scale_(kMagsacTableSize / threshold),
      least_share_(std::clamp(least / threshold, kLeastShare, kLargestShare)),
      inverse_threshold_(1.0 / threshold),
      scales_norm_(1.0 / (1.0 / least_share_ - 1.0)) {}

double Score::operator()(double residual) const {
  // A comparison that is false for NaN comes first in each, so that NaN scores 0.
  switch (kind_) {
    case ScoreKind::kInlierCount:
      return residual <= threshold_ ? 1.0 : 0.0;
    case ScoreKind::kMsac:
      return std::max(0.0, 1.0 - residual * residual * inverse_threshold_squared_);
    case ScoreKind::kMagsac:
      return FromTable(residual);
    case ScoreKind::kScales:
      return OverScales(residual);
    case ScoreKind::kGaussianUniform:
      break;
  }
  const double ratio = odds_ * std::exp(-residual * residual * half_inverse_variance_);
  return ratio > 0.0 ? std::log1p(ratio) * inverse_log_ : 0.0;
}

double Score::Derivative(double residual) const {
  switch (kind_) {
    case ScoreKind::kInlierCount:
      return 0.0;
    case ScoreKind::kMsac:
      return residual < threshold_ ? -2.0 * residual * inverse_threshold_squared_ : 0.0;
    case ScoreKind::kMagsac:
      if (!(residual > 0.0)) return 0.0;
      return -residual * MagsacLoss(threshold_, residual_dof_).ExactWeight(residual) * inverse_threshold_squared_;
    case ScoreKind::kScales: {
      const double share = residual * inverse_threshold_;
      if (!(share < 1.0)) return 0.0;
      const double inverse = 1.0 / std::max(share, least_share_);
      return -2.0 / 3.0 * share * (Cube(inverse) - 1.0) * scales_norm_ * inverse_threshold_;
    }
    case ScoreKind::kGaussianUniform:
      break;
  }
  const double ratio = odds_ * std::exp(-residual * residual * half_inverse_variance_);
  return ratio > 0.0 ? -2.0 * residual * half_inverse_variance_ * ratio / (1.0 + ratio) * inverse_log_ : 0.0;
}

double Score::FromTable(double residual) const {
  // Without a branch, which would be guessed wrong for every other point; NaN goes to the end, where the score is 0.
  const double scaled = std::abs(residual) * table_scale_;
  const double place = scaled < kMagsacTableSize ? scaled : kMagsacTableSize;
  const int cell = static_cast<int>(place);
  return table_[cell] + (place - cell) * (table_[cell + 1] - table_[cell]);
}

double Score::Sum(const double* residuals, int count) const {
  if (kind_ == ScoreKind::kInlierCount) {
    std::int64_t inliers = 0;
    for (int i = 0; i < count; ++i) inliers += residuals[i] <= threshold_ ? 1 : 0;
    return static_cast<double>(inliers);
  }
  if (kind_ == ScoreKind::kMsac)
    return SumInLanes(count, [&](int i) {
      const double share = 1.0 - residuals[i] * residuals[i] * inverse_threshold_squared_;
      return share > 0.0 ? share : 0.0;
    });
  if (kind_ == ScoreKind::kMagsac) return SumInLanes(count, [&](int i) { return FromTable(residuals[i]); });
  if (kind_ == ScoreKind::kScales) return SumInLanes(count, [&](int i) { return OverScales(residuals[i]); });
  return SumGaussianUniform(residuals, count);
}

double Score::Sum(const double* residuals, const double* weights, int count) const {
  if (kind_ == ScoreKind::kMsac)
    return SumInLanes(count, [&](int i) {
      const double share = 1.0 - residuals[i] * residuals[i] * inverse_threshold_squared_;
      return share > 0.0 ? weights[i] * share : 0.0;
    });
  if (kind_ == ScoreKind::kScales)
    return SumInLanes(count, [&](int i) { return weights[i] * OverScales(residuals[i]); });
  return SumInLanes(count, [&](int i) { return weights[i] * (*this)(residuals[i]); });
}

double Score::OverScales(double residual) const {
  // Without a branch; NaN counts as ε, where the score is 0. In shares of ε: their cubes are ordinary numbers.
  const double share = residual * inverse_threshold_;
  const double near = share < 1.0 ? share : 1.0;
  const double inverse = 1.0 / (near > least_share_ ? near : least_share_);
  const double slope = (Cube(inverse) - 1.0) / 3.0;
  return (inverse - 1.0 - near * near * slope) * scales_norm_;
}

double Score::SumGaussianUniform(const double* residuals, int count) const {
  // exp(-45) is 3e-20: points farther away add nothing that a double could hold, and most points are farther away.
  constexpr double kFar = 45.0;
  constexpr int kChunk = 64;
  double exponents[kChunk];
  double sum = 0.0;
  for (int begin = 0; begin < count; begin += kChunk) {
    int near = 0;
    for (int i = begin; i < std::min(begin + kChunk, count); ++i) {
      exponents[near] = residuals[i] * residuals[i] * half_inverse_variance_;
      near += exponents[near] < kFar ? 1 : 0;
    }
    const Eigen::Map<const Eigen::ArrayXd> x(exponents, near);
    sum += (1.0 + odds_ * (-x).exp()).log().sum();
  }
  return sum * inverse_log_;
}

}  // namespace diffsac
