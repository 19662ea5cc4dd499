#pragma once

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

}  // namespace diffsac
