#pragma once

namespace diffsac {

/// The upper incomplete gamma function Γ(a, x) = ∫_x^∞ t^(a−1) e^(−t) dt for a = twice_a / 2 with twice_a ≥ 0, x ≥ 0.
/// From Γ(0, x) = E₁(x), Γ(1/2, x) = √π erfc(√x) and Γ(a + 1, x) = a Γ(a, x) + x^a e^(−x) (Abramowitz and Stegun,
/// 6.5.17 and 6.5.22); relative error below 1e-12. Γ(0, 0) is infinite.
double UpperIncompleteGamma(int twice_a, double x);

/// The lower incomplete gamma function γ(a, x) = Γ(a) − Γ(a, x), twice_a ≥ 1; absolute error below 1e-14·Γ(a).
double LowerIncompleteGamma(int twice_a, double x);

/// E₁(x) = ∫_x^∞ e^(−t)/t dt for x ≥ 0.
double ExponentialIntegral(double x);

}  // namespace diffsac
