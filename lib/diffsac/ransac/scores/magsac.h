#pragma once

#include <cmath>

#include "diffsac/geometry/lanes.h"
#include "diffsac/ransac/scores/magsac_loss.h"
#include "diffsac/ransac/scores/score.h"

namespace diffsac {

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
