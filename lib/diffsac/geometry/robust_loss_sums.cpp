#include "diffsac/geometry/robust_loss_sums.h"

#include <limits>

#include "diffsac/geometry/lanes.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

double Slope(double inverse) { return (inverse * inverse * inverse - 1.0) / 3.0; }

/// The loss over scales of residuals in units of the greatest scale; one that is no number counts as 1.
struct OverScales {
  explicit OverScales(const RobustLoss& loss)
      : unit(1.0 / loss.scale),
        least(loss.least / loss.scale),
        most(loss.scale / loss.least),
        norm(1.0 / Slope(most)) {}

  double Share(double residual) const {
    const double share = residual * unit;
    return share < 1.0 ? share : 1.0;
  }
  double Inverse(double share) const { return 1.0 / (share > least ? share : least); }
  /// Scales below the residual count in full, those above by (r/t)². In squares of the greatest scale.
  double Value(double share) const {
    const double inverse = Inverse(share);
    return (most - inverse + share * share * ((inverse * inverse * inverse - 1.0) / 3.0)) * norm;
  }
  double Weight(double share) const {
    const double inverse = Inverse(share);
    return (inverse * inverse * inverse - 1.0) / 3.0 * norm;
  }

  double unit, least, most, norm;
};

DIFFSAC_VECTOR_CLONES
double SumTruncated(const double* residuals, const double* weights, int count, double square) {
  return SumInLanes(
      residuals, weights, count, [](double residual) { return residual * residual; },
      [=](double s) { return s < square ? s : square; });
}

DIFFSAC_VECTOR_CLONES
double SumOverScales(const double* residuals, const double* weights, int count, OverScales scales) {
  return SumInLanes(
      residuals, weights, count, [=](double residual) { return scales.Share(residual); },
      [=](double share) { return scales.Value(share); });
}

DIFFSAC_VECTOR_CLONES
void TruncatedWeights(const double* residuals, const double* weights, int count, double square, double* out) {
  for (int i = 0; i < count; ++i) out[i] = weights[i] * (residuals[i] * residuals[i] <= square ? 1.0 : 0.0);
}

DIFFSAC_VECTOR_CLONES
void WeightsOverScales(const double* residuals, const double* weights, int count, OverScales scales, double* out) {
  constexpr int kChunk = 64;
  double shares[kChunk];
  for (int begin = 0; begin < count; begin += kChunk) {
    const int size = std::min(kChunk, count - begin);
    for (int i = 0; i < size; ++i) shares[i] = scales.Share(residuals[begin + i]);
    for (int i = 0; i < size; ++i) out[begin + i] = weights[begin + i] * scales.Weight(shares[i]);
  }
}

/// The squares themselves are truncated where no finite one is.
bool IsTruncated(const RobustLoss& loss) {
  return loss.kind == LossKind::kTruncated || loss.kind == LossKind::kTrivial;
}
double SquareOf(const RobustLoss& loss) {
  return loss.kind == LossKind::kTrivial ? std::numeric_limits<double>::max() : loss.scale * loss.scale;
}

}  // namespace

double SumLoss(const RobustLoss& loss, const double* residuals, const double* weights, int count) {
  if (IsTruncated(loss)) return SumTruncated(residuals, weights, count, SquareOf(loss));
  if (loss.kind == LossKind::kMarginalised)
    return SumOverScales(residuals, weights, count, OverScales(loss)) * (loss.scale * loss.scale);
  double sum = 0.0;
  for (int i = 0; i < count; ++i) sum += weights[i] * loss.Value(residuals[i] * residuals[i]);
  return sum;
}

void LossWeights(const RobustLoss& loss, const double* residuals, const double* weights, int count, double* out) {
  if (IsTruncated(loss)) {
    TruncatedWeights(residuals, weights, count, SquareOf(loss), out);
  } else if (loss.kind == LossKind::kMarginalised) {
    WeightsOverScales(residuals, weights, count, OverScales(loss), out);
  } else {
    for (int i = 0; i < count; ++i) out[i] = weights[i] * loss.Weight(residuals[i] * residuals[i]);
  }
}

}  // namespace diffsac
