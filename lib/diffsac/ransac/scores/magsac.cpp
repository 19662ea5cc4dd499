#include "diffsac/ransac/scores/magsac.h"

#include <algorithm>
#include <array>
#include <boost/math/special_functions/expint.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

constexpr std::array<double, MagsacLoss::kMaxDof> kChiQuantiles99 = {
    2.575829303548900, 3.034854258770293, 3.368214175218708, 3.643721193503647, 3.884105105347836, 4.100230948345577};
/// Residuals below this share of the threshold weigh as if they were there.
constexpr double kSmallestShare = 1e-3;

/// As precise as a double, without detours over a longer type.
using Precision = boost::math::policies::policy<boost::math::policies::promote_double<false>>;

/// Γ(a, x) for a = twice_a / 2 ≥ 0; infinite for a = x = 0.
double UpperIncompleteGamma(int twice_a, double x) {
  if (twice_a > 0) return boost::math::tgamma(0.5 * twice_a, x, Precision());
  return x > 0.0 ? boost::math::expint(1, x, Precision()) : std::numeric_limits<double>::infinity();
}

/// γ(a, x) for a = twice_a / 2 > 0.
double LowerIncompleteGamma(int twice_a, double x) { return boost::math::tgamma_lower(0.5 * twice_a, x, Precision()); }

/// One entry more than there are: interpolation at the end reads it, with weight 0.
using Table = std::array<double, kMagsacTableSize + 2>;

Table MakeTable(int dof) {
  const MagsacLoss loss(1.0, dof);
  Table table;
  for (int i = 0; i <= kMagsacTableSize; ++i) table[i] = loss.Score(static_cast<double>(i) / kMagsacTableSize);
  table.back() = 0.0;
  return table;
}

template <int kDof>
const Table& TableOf() {
  static const Table table = MakeTable(kDof);
  return table;
}

}  // namespace

double ChiQuantile99(int dof) {
  if (dof < 1 || dof > MagsacLoss::kMaxDof) throw Error("residual_dof must be 1 to 6, got " + std::to_string(dof));
  return kChiQuantiles99[dof - 1];
}

MagsacLoss::MagsacLoss(double threshold, int dof)
    : threshold_(threshold),
      dof_(dof),
      half_square_(0.5 * ChiQuantile99(dof) * ChiQuantile99(dof)),
      tail_(UpperIncompleteGamma(dof - 1, half_square_)),
      total_(LowerIncompleteGamma(dof + 1, half_square_)) {}

double MagsacLoss::Score(double residual) const {
  const double share = residual / threshold_;
  // Written so that NaN fails.
  if (!(share < 1.0)) return 0.0;
  const double x = half_square_ * share * share;
  if (!(x > 0.0)) return 1.0;
  const double loss = LowerIncompleteGamma(dof_ + 1, x) + x * (UpperIncompleteGamma(dof_ - 1, x) - tail_);
  return std::clamp(1.0 - loss / total_, 0.0, 1.0);
}

double MagsacLoss::ExactWeight(double residual) const {
  const double share = residual / threshold_;
  if (!(share < 1.0)) return 0.0;
  const double x = half_square_ * share * share;
  return 2.0 * half_square_ * (UpperIncompleteGamma(dof_ - 1, x) - tail_) / total_;
}

double MagsacLoss::Weight(double residual) const {
  // In this order max keeps a NaN.
  return ExactWeight(std::max(residual, kSmallestShare * threshold_));
}

const double* MagsacScoreTable(int dof) {
  switch (dof) {
    case 1:
      return TableOf<1>().data();
    case 2:
      return TableOf<2>().data();
    case 3:
      return TableOf<3>().data();
    case 4:
      return TableOf<4>().data();
    case 5:
      return TableOf<5>().data();
    case 6:
      return TableOf<6>().data();
    default:
      throw Error("residual_dof must be 1 to 6, got " + std::to_string(dof));
  }
}

}  // namespace diffsac
