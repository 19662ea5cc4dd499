#include "diffsac/guidance/diffusion/ancestral_samplers.h"

#include <algorithm>
#include <cmath>

namespace diffsac {
namespace {

/// Variance that the forward process adds from t to the noisier s, 1 − (α_s/α_t)².
double StepVariance(const TimePoint& s, const TimePoint& t) {
  const double ratio = s.alpha / t.alpha;
  return std::max(0.0, 1.0 - ratio * ratio);
}

}  // namespace

LinearUpdate DdpmUpdate(const TimePoint& s, const TimePoint& t) {
  const double step_variance = StepVariance(s, t);
  const double s_variance = s.sigma * s.sigma;
  const double t_variance = t.sigma * t.sigma;
  return {s.alpha / t.alpha * t_variance / s_variance, t.alpha * step_variance / s_variance,
          std::sqrt(t_variance * step_variance / s_variance)};
}

LinearUpdate RenoiseUpdate(const TimePoint&, const TimePoint& t) { return {0.0, t.alpha, t.sigma}; }

LinearUpdate DdimUpdate(const TimePoint& s, const TimePoint& t, double eta) {
  const double deviation = eta * t.sigma / s.sigma * std::sqrt(StepVariance(s, t));
  const double kept = std::sqrt(std::max(0.0, t.sigma * t.sigma - deviation * deviation)) / s.sigma;
  return {kept, t.alpha - kept * s.alpha, deviation};
}

}  // namespace diffsac
