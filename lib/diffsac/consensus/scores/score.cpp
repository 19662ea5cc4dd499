#include "diffsac/consensus/scores/score.h"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "diffsac/consensus/scores/noise_estimate.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/lane_sums.h"
#include "diffsac/geometry/square_bounds.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {

namespace {

/// Of kMarginalised: the smallest scale, as a share of ε. At the second all scales are one, and the score is MSAC.
constexpr double kLeastShare = 1e-3, kLargestShare = 0.99;

double Cube(double x) { return x * x * x; }

double Same(double x) { return x; }

/// Constants of kMarginalised: a residual's contribution is a function of its share of ε.
template <class Real>
struct OverScales {
  Real least, norm;

  /// NaN counts as ε, where the score is 0.
  static Real Near(Real share) { return share < Real(1) ? share : Real(1); }
  /// near: Near(share). In shares of ε: their cubes are ordinary numbers.
  Real operator()(Real near) const {
    const Real inverse = Real(1) / (near > least ? near : least);
    const Real slope = (inverse * inverse * inverse - Real(1)) / Real(3);
    return (inverse - Real(1) - near * near * slope) * norm;
  }
};

DIFFSAC_VECTOR_CLONES
double SumMsac(const double* residuals, const double* weights, int count, double inverse_square) {
  return SumInLanes(
      residuals, weights, count, [=](double residual) { return 1.0 - residual * residual * inverse_square; },
      [](double share) { return share > 0.0 ? share : 0.0; });
}

DIFFSAC_VECTOR_CLONES
double SumOverScales(const double* residuals, const double* weights, int count, double inverse,
                     OverScales<double> scales) {
  return SumInLanes(
      residuals, weights, count, [=](double residual) { return OverScales<double>::Near(residual * inverse); }, scales);
}

/// 1/√x from above, by up to kRootSlack: without a root and a quotient, which all else would wait for.
constexpr float kRootSlack = 1.9e-3f;
inline float InverseRootFromAbove(float x) {
  const float guess = std::bit_cast<float>(0x5f375a86u - (std::bit_cast<std::uint32_t>(x) >> 1));
  // Newton's step ends below, by 1.76e-3 at most.
  return guess * (1.5f - 0.5f * x * guess * guess) * (1.0f + 1.8e-3f);
}

/// Of kMarginalised: a term as a function of the inverse share v is v − 1 − near² (v³ − 1)/3, largest at v = 1/near,
/// and rises with v up to there; the slack of v is made up for in Score::Bound.
DIFFSAC_BOUND_CLONES
float BoundOverScales(const float* squares, const float* weights, int count, float most, float norm) {
  return SumFloats<kBoundBlock>(
      squares, weights, count, [](float square) { return square < 1.0f ? square : 1.0f; },
      [=](float square) {
        const float root = InverseRootFromAbove(square + 1e-12f);
        const float inverse = root < most ? root : most;
        return (inverse - 1.0f - square * ((inverse * inverse * inverse - 1.0f) * (1.0f / 3.0f))) * norm;
      });
}

}  // namespace

Score::Score(ScoreKind kind, double threshold, double sigma, double odds, int residual_dof, double least,
             const LikelihoodSetting& likelihood)
    : kind_(kind),
      threshold_(threshold),
      unit_(threshold),
      inverse_threshold_squared_(1.0 / (threshold * threshold)),
      half_inverse_variance_(0.5 / (sigma * sigma)),
      odds_(odds),
      inverse_log_(1.0 / std::log1p(odds)),
      residual_dof_(residual_dof),
      table_(kind == ScoreKind::kMagsac ? MagsacScoreTable(residual_dof) : nullptr),
      table_scale_(kMagsacTableSize / threshold),
      least_share_(std::clamp(least / threshold, kLeastShare, kLargestShare)),
      inverse_threshold_(1.0 / threshold),
      scales_norm_(1.0 / (1.0 / least_share_ - 1.0)),
      first_magsac_(threshold, likelihood.half_width) {
  if (kind == ScoreKind::kMarginalLikelihood) {
    marginal_.emplace(likelihood.half_width, likelihood.dimension, likelihood.free, likelihood.noise_prior, sigma);
    unit_ = likelihood.half_width;
  }
  if (kind == ScoreKind::kMixtureProfile) {
    profile_.emplace(least / kSigmasOfInlier, threshold / kSigmasOfInlier, 2.0 * likelihood.half_width,
                     likelihood.dimension);
    unit_ = profile_->reach();
  }
}

double Score::operator()(double residual) const {
  // A comparison that is false for NaN comes first in each, so that NaN scores 0.
  switch (kind_) {
    case ScoreKind::kInlierCount:
      return residual <= threshold_ ? 1.0 : 0.0;
    case ScoreKind::kMsac:
      return std::max(0.0, 1.0 - residual * residual * inverse_threshold_squared_);
    case ScoreKind::kMagsac:
      return FromTable(residual);
    case ScoreKind::kMarginalised:
      return OverScales<double>{least_share_, scales_norm_}(OverScales<double>::Near(residual * inverse_threshold_));
    case ScoreKind::kFirstMagsac:
      return first_magsac_.Score(residual);
    case ScoreKind::kMarginalLikelihood:
    case ScoreKind::kMixtureProfile:
      throw Error("the score " + ToString(kind_) + " is no sum over points");
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
    case ScoreKind::kMarginalised: {
      const double share = residual * inverse_threshold_;
      if (!(share < 1.0)) return 0.0;
      const double inverse = 1.0 / std::max(share, least_share_);
      return -2.0 / 3.0 * share * (Cube(inverse) - 1.0) * scales_norm_ * inverse_threshold_;
    }
    case ScoreKind::kFirstMagsac:
      return first_magsac_.Derivative(residual);
    case ScoreKind::kMarginalLikelihood:
    case ScoreKind::kMixtureProfile:
      throw Error("the score " + ToString(kind_) + " is no sum over points");
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
  if (kind_ == ScoreKind::kMsac) return SumMsac(residuals, nullptr, count, inverse_threshold_squared_);
  if (kind_ == ScoreKind::kMagsac)
    return SumInLanes(residuals, nullptr, count, Same, [&](double residual) { return FromTable(residual); });
  if (kind_ == ScoreKind::kMarginalised)
    return SumOverScales(residuals, nullptr, count, inverse_threshold_, {least_share_, scales_norm_});
  if (kind_ == ScoreKind::kFirstMagsac) return Sum(residuals, nullptr, count);
  return SumGaussianUniform(residuals, count);
}

double Score::Sum(const double* residuals, const double* weights, int count) const {
  if (kind_ == ScoreKind::kMsac) return SumMsac(residuals, weights, count, inverse_threshold_squared_);
  if (kind_ == ScoreKind::kMarginalised)
    return SumOverScales(residuals, weights, count, inverse_threshold_, {least_share_, scales_norm_});
  return SumInLanes(residuals, weights, count, Same, [&](double residual) { return (*this)(residual); });
}

double Score::OfAll(const double* residuals, const double* weights, int count, double bar) const {
  if (marginal_) return (*marginal_)(residuals, weights, count, bar);
  if (profile_) return (*profile_)(residuals, weights, count, bar);
  return weights == nullptr ? Sum(residuals, count) : Sum(residuals, weights, count);
}

double Score::BoundOfAll(const SquareHistogram& histogram) const {
  return marginal_ ? marginal_->Bound(histogram) : profile_->Bound(histogram);
}

bool Score::HasBound() const { return kind_ == ScoreKind::kMsac || kind_ == ScoreKind::kMarginalised || !IsSum(); }

double Score::Bound(const float* squares, const float* weights, int count) const {
  if (kind_ == ScoreKind::kMsac) return MsacBound(squares, weights, count);
  // A term is a difference of numbers up to `most`, times the norm; v's slack takes off its square.
  const double most = 1.0 / least_share_;
  const double slack = (16.0 * std::numeric_limits<float>::epsilon() + kRootSlack * kRootSlack) * scales_norm_ * most;
  return static_cast<double>(
             BoundOverScales(squares, weights, count, static_cast<float>(most), static_cast<float>(scales_norm_))) +
         slack * count;
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
