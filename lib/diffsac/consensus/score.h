#pragma once

#include <cstdint>

#include "diffsac/core/enum_names.h"

namespace diffsac {

/// How a hypothesis is judged; larger is better, always within [0, N].
///   kInlierCount      Σ [r ≤ ε]                                       (Fischler and Bolles, 1981; the paper's default)
///   kMsac             Σ max(0, 1 − r²/ε²)                             (Torr and Zisserman, MLESAC, CVIU 2000)
///   kGaussianUniform  Σ of the log-likelihood ratio log(1 + k·exp(−r²/2σ²)) / log(1 + k): an inlier is Gaussian
///                     with σ, an outlier uniform; k is the odds of the two densities at r = 0
///   kMagsac           Σ 1 − ρ(r)/ρ(ε), the loss ρ of MAGSAC++ marginalised over σ up to ε/k (see magsac.h)
///   kMarginalised           Σ ∫ max(0, 1 − r²/t²) dt/t², t from `least` to ε, divided by its value for r = 0: MSAC
///   over all
///                     scales, each a share 1/t of its octave. Needs no ε that suits the noise: between the two a point
///                     counts as 1/r, whatever ε is
enum class ScoreKind { kInlierCount, kMsac, kGaussianUniform, kMagsac, kMarginalised };

template <>
inline constexpr auto kEnumNames<ScoreKind> = NamesOf<ScoreKind>({{ScoreKind::kInlierCount, "inlier_count"},
                                                                  {ScoreKind::kMsac, "msac"},
                                                                  {ScoreKind::kGaussianUniform, "gaussian_uniform"},
                                                                  {ScoreKind::kMagsac, "magsac_pp"},
                                                                  {ScoreKind::kMarginalised, "marginalised_msac"}});

/// A score with its constants worked out once.
class Score {
 public:
  /// threshold: ε, linear. sigma and odds are used by kGaussianUniform only, residual_dof (1 … 6) by kMagsac only,
  /// least (at least ε: MSAC) by kMarginalised only.
  Score(ScoreKind kind, double threshold, double sigma, double odds, int residual_dof = 1, double least = 0.0);
  /// The contribution of one residual (linear), in [0, 1], never increasing in r.
  double operator()(double residual) const;
  /// d/dr of it, ≤ 0; 0 where it jumps. Of kMagsac: of the exact loss, from which the score differs by under 1e-6.
  double Derivative(double residual) const;
  /// The sum over `count` residuals, the hot loop's form; an exact count for kInlierCount.
  double Sum(const double* residuals, int count) const;
  /// Of contributions times weights.
  double Sum(const double* residuals, const double* weights, int count) const;
  ScoreKind kind() const { return kind_; }
  double threshold() const { return threshold_; }
  /// Whether there is a quick bound for this kind.
  bool HasBound() const;
  /// At least the sum of contributions (times weights, unless null) of residuals whose squares, in squares of the
  /// threshold, are at least these; count ≤ kBoundBlock. In single precision. Only where HasBound().
  double Bound(const float* squares, const float* weights, int count) const;

 private:
  double FromTable(double residual) const;
  double SumGaussianUniform(const double* residuals, int count) const;

  ScoreKind kind_;
  double threshold_;
  double inverse_threshold_squared_;
  double half_inverse_variance_;
  double odds_;
  double inverse_log_;
  int residual_dof_;
  const double* table_;  ///< Of kMagsac, for residuals 0 … threshold.
  double table_scale_;
  double least_share_;  ///< Of kMarginalised: of ε.
  double inverse_threshold_;
  double scales_norm_;
};

}  // namespace diffsac
