#pragma once

#include <cmath>

#include "diffsac/consensus/scores/score.h"
#include "diffsac/geometry/lanes.h"

namespace diffsac {

/// The marginalised loss of MAGSAC++ (Barath, Noskova, Ivashechkin, Matas, CVPR 2020, section 3).
///
/// Inlier residuals r of `dof` degrees of freedom n are χ-distributed with a scale σ, cut at kσ (k: the .99 quantile);
/// σ is unknown, uniform in (0, τ/k], so that no residual above τ is an inlier. With x = r²k²/2τ²:
///   w(r) ∝ Γ((n−1)/2, x) − Γ((n−1)/2, k²/2)                        the weight of iteratively reweighted least squares
///   ρ(r) = ∫₀^r s·w(s) ds ∝ γ((n+1)/2, x) + x·(Γ((n−1)/2, x) − Γ((n−1)/2, k²/2))
/// for r ≤ τ; beyond, the weight is 0 and the loss ρ(τ). The score of a residual is 1 − ρ(r)/ρ(τ).
///
/// By its definition n is 1 for the distance to a line or plane, 2 for transfer into one image, 4 for correspondences
/// (the paper's choice; see kResidualDof in model_hooks.h for what works). For n = 1 the weight grows without bound, as
/// −log r; `Weight` is capped at its value for r = τ/1000.
class MagsacLoss {
 public:
  static constexpr int kMaxDof = 6;

  /// threshold: τ, linear, positive. dof: n, 1 … kMaxDof.
  MagsacLoss(double threshold, int dof);
  /// 1 − ρ(r)/ρ(τ), in [0, 1]; 0 for NaN. Exact.
  double Score(double residual) const;
  /// −(dScore/dr)/r in units of 1/τ²; 0 beyond τ and for NaN. Infinite at 0 for n = 1.
  double ExactWeight(double residual) const;
  /// The same with the cap that keeps it finite.
  double Weight(double residual) const;
  double threshold() const { return threshold_; }

 private:
  double threshold_;
  int dof_;
  double half_square_;  ///< k²/2
  double tail_;         ///< Γ((n−1)/2, k²/2)
  double total_;        ///< ρ(τ) in the units above.
};

/// The .99 quantile of the χ distribution with n degrees of freedom, 1 … 6.
double ChiQuantile99(int dof);

/// Score(r) for τ = 1 at r = i / kMagsacTableSize, i = 0 … kMagsacTableSize; made at the first use. Linear
/// interpolation in it is within 1e-6 of MagsacLoss::Score.
inline constexpr int kMagsacTableSize = 4096;
const double* MagsacScoreTable(int dof);

/// Σ 1 − ρ(r)/ρ(ε), the loss ρ of MAGSAC++ marginalised over σ up to ε/k (MagsacLoss), from a table that is within 1e-6
/// of it; the derivative is that of the exact loss.
class MagsacScore : public ScoreFunction {
 public:
  explicit MagsacScore(const ScoreSetting& setting)
      : threshold_(setting.threshold),
        inverse_square_(1.0 / (setting.threshold * setting.threshold)),
        dof_(setting.residual_dof),
        table_(MagsacScoreTable(setting.residual_dof)),
        table_scale_(kMagsacTableSize / setting.threshold) {}
  double operator()(double residual) const override {
    // Without a branch, which would be guessed wrong for every other point; NaN goes to the end, where the score is 0.
    const double scaled = std::abs(residual) * table_scale_;
    const double place = scaled < kMagsacTableSize ? scaled : kMagsacTableSize;
    const int cell = static_cast<int>(place);
    return table_[cell] + (place - cell) * (table_[cell + 1] - table_[cell]);
  }
  double Derivative(double residual) const override {
    if (!(residual > 0.0)) return 0.0;
    return -residual * MagsacLoss(threshold_, dof_).ExactWeight(residual) * inverse_square_;
  }
  double Sum(const double* residuals, const double* weights, int count) const override {
    return SumInLanes(
        residuals, weights, count, [](double residual) { return residual; },
        [this](double residual) { return MagsacScore::operator()(residual); });
  }
  double unit() const override { return threshold_; }

 private:
  double threshold_, inverse_square_;
  int dof_;
  const double* table_;  ///< For residuals 0 … ε.
  double table_scale_;
};

}  // namespace diffsac
