#include "diffsac/consensus/incomplete_gamma.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace diffsac {
namespace {

/// −γ − ln x − Σ (−x)^k / (k·k!) (Abramowitz and Stegun, 5.1.11); the terms cancel too much beyond x = 1.
double SeriesE1(double x) {
  double sum = -std::numbers::egamma - std::log(x), term = 1.0;
  for (int k = 1; k < 40; ++k) {
    term *= -x / k;
    sum -= term / k;
    if (std::abs(term) < 1e-18) break;
  }
  return sum;
}

/// e^(−x) · 1/(x+1− 1/(x+3− 4/(x+5− …))) (the even part of 5.1.22), evaluated from the far end.
double FractionE1(double x) {
  // Convergence is slowest at x = 1, the least that is used.
  const int levels = 20 + static_cast<int>(80.0 / x);
  double tail = 0.0;
  for (int k = levels; k >= 1; --k) tail = k * static_cast<double>(k) / (x + 2.0 * k + 1.0 - tail);
  return std::exp(-x) / (x + 1.0 - tail);
}

}  // namespace

double ExponentialIntegral(double x) {
  if (!(x > 0.0)) return std::numeric_limits<double>::infinity();
  return x <= 1.0 ? SeriesE1(x) : FractionE1(x);
}

double UpperIncompleteGamma(int twice_a, double x) {
  const bool whole = twice_a % 2 == 0;
  double a = whole ? 0.0 : 0.5;
  if (whole && twice_a == 0) return ExponentialIntegral(x);
  double value = std::sqrt(std::numbers::pi) * std::erfc(std::sqrt(x));
  if (whole) {
    // From a = 1, so that Γ(0, 0) does not come in.
    a = 1.0;
    value = std::exp(-x);
  }
  for (; 2.0 * a < twice_a; a += 1.0) value = a * value + std::pow(x, a) * std::exp(-x);
  return value;
}

double LowerIncompleteGamma(int twice_a, double x) {
  return std::tgamma(0.5 * twice_a) - UpperIncompleteGamma(twice_a, x);
}

}  // namespace diffsac
