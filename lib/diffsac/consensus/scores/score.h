#pragma once

#include <cstdint>
#include <optional>

#include "diffsac/consensus/scores/magsac.h"
#include "diffsac/consensus/scores/marginal_likelihood.h"
#include "diffsac/consensus/scores/mixture_profile.h"
#include "diffsac/core/enum_names.h"

namespace diffsac {

/// How a hypothesis is judged; larger is better, never negative. Sums over points, within [0, N]:
///   kInlierCount      Σ [r ≤ ε]                                       (Fischler and Bolles, 1981; the paper's default)
///   kMsac             Σ max(0, 1 − r²/ε²)                             (Torr and Zisserman, MLESAC, CVIU 2000)
///   kGaussianUniform  Σ of the log-likelihood ratio log(1 + k·exp(−r²/2σ²)) / log(1 + k): an inlier is Gaussian
///                     with σ, an outlier uniform; k is the odds of the two densities at r = 0
///   kFirstMagsac      Σ of the log-likelihood ratio of the same two, averaged over σ up to ε/k (FirstMagsac, magsac.h)
///   kMagsac           Σ 1 − ρ(r)/ρ(ε), the loss ρ of MAGSAC++ marginalised over σ up to ε/k (see magsac.h)
///   kMarginalised           Σ ∫ max(0, 1 − r²/t²) dt/t², t from `least` to ε, divided by its value for r = 0: MSAC
///   over all
///                     scales, each a share 1/t of its octave. Needs no ε that suits the noise: between the two a point
///                     counts as 1/r, whatever ε is
/// Of all residuals at once, log-likelihood ratios to a model without inliers, in nats:
///   kMarginalLikelihood  with σ integrated out and the inliers chosen          (Pritts and others;
///   marginal_likelihood.h) kMixtureProfile      with σ and the share of inliers that are likeliest (mixture_profile.h)
enum class ScoreKind {
  kInlierCount,
  kMsac,
  kGaussianUniform,
  kMixtureProfile,
  kFirstMagsac,
  kMagsac,
  kMarginalLikelihood,
  kMarginalised
};

template <>
inline constexpr auto kEnumNames<ScoreKind> = NamesOf<ScoreKind>({{ScoreKind::kInlierCount, "inlier_count"},
                                                                  {ScoreKind::kMsac, "msac"},
                                                                  {ScoreKind::kGaussianUniform, "gaussian_uniform"},
                                                                  {ScoreKind::kMixtureProfile, "gaussian_uniform_em"},
                                                                  {ScoreKind::kFirstMagsac, "magsac"},
                                                                  {ScoreKind::kMagsac, "magsac_pp"},
                                                                  {ScoreKind::kMarginalLikelihood,
                                                                   "marginal_likelihood"},
                                                                  {ScoreKind::kMarginalised, "marginalised_msac"}});

/// What likelihoods know beside σ and ε.
struct LikelihoodSetting {
  double half_width = 1.0;   ///< a: an outlier's residual is uniform within ±a; linear.
  int dimension = 1;         ///< d, of a residual.
  int free = 0;              ///< Points that the model takes, whatever the noise: γ.
  double noise_prior = 0.0;  ///< n₀ of the marginal likelihood.
};

/// A score with its constants worked out once.
class Score {
 public:
  /// threshold: ε, linear. sigma is used by kGaussianUniform and, for the prior, by kMarginalLikelihood only, odds by
  /// kGaussianUniform only, residual_dof (1 … 6) by kMagsac only, least by kMarginalised (at least ε: MSAC) and by
  /// kMixtureProfile only, whose σ are those of thresholds (kSigmasOfInlier) from it to ε.
  Score(ScoreKind kind, double threshold, double sigma, double odds, int residual_dof = 1, double least = 0.0,
        const LikelihoodSetting& likelihood = {});
  /// Whether the score is a sum over points.
  bool IsSum() const { return !marginal_ && !profile_; }
  /// The contribution of one residual (linear), in [0, 1], never increasing in r. Where IsSum().
  double operator()(double residual) const;
  /// d/dr of it, ≤ 0; 0 where it jumps. Of kMagsac: of the exact loss, from which the score differs by under 1e-6.
  double Derivative(double residual) const;
  /// Of all residuals of a model, with weights unless null: where IsSum() the sum, else what the score is. That gives
  /// up once it is known to be below `bar`, returning `bar`.
  double OfAll(const double* residuals, const double* weights, int count, double bar = 0.0) const;
  /// Unless IsSum(), at least the score of residuals whose squares, in squares of unit(), are at least the counted
  /// ones.
  double BoundOfAll(const SquareHistogram& histogram) const;
  /// The sum over `count` residuals, the hot loop's form; an exact count for kInlierCount.
  double Sum(const double* residuals, int count) const;
  /// Of contributions times weights.
  double Sum(const double* residuals, const double* weights, int count) const;
  ScoreKind kind() const { return kind_; }
  double threshold() const { return threshold_; }
  /// What residuals are measured in for bounds: ε where IsSum(), beyond which all count alike in any case.
  double unit() const { return unit_; }
  /// Whether there is a quick bound for this kind: Bound where IsSum(), BoundOfAll elsewhere.
  bool HasBound() const;
  /// At least the sum of contributions (times weights, unless null) of residuals whose squares, in squares of the
  /// threshold, are at least these; count ≤ kBoundBlock. In single precision. Only where HasBound() and IsSum().
  double Bound(const float* squares, const float* weights, int count) const;

 private:
  double FromTable(double residual) const;
  double SumGaussianUniform(const double* residuals, int count) const;

  ScoreKind kind_;
  double threshold_;
  double unit_;
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
  FirstMagsac first_magsac_;
  std::optional<MarginalLikelihood> marginal_;
  std::optional<MixtureProfile> profile_;
};

}  // namespace diffsac
