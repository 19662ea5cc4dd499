#pragma once

#include <cstdint>
#include <vector>

#include "diffsac/estimate/robust_estimator.h"

namespace diffsac {

/// How likely each point of the problem is right under the estimate's model, N values; 0 without a model, and of
/// several structures nothing. By Bayes: a right point's residual is of noise σ, now and then (5 %) of three times
/// that; a wrong one's has the density of residuals just beyond the noise, where mismatches that are nearly right
/// crowd, and that of places anywhere at least (ChanceShare). Before the residual a point is as likely as its score or
/// ratio says (MatchPriors), all log odds moved by one number, which maximises the likelihood, so that no scale of
/// scores is taken at its word. That the model is right is taken for granted (log10_nfa asks).
std::vector<float> PosteriorsOf(const NormalizedProblem& space, const Estimate& estimate);

/// Points within noise of an estimate's model: N values, 1 for those within the inliers' threshold, or 2.5 σ where that
/// is more. wrong_share: how likely a wrong point is among them, as PosteriorsOf takes it.
struct MatchesWithinNoise {
  std::vector<std::uint8_t> inside;
  double wrong_share = 1.0;
};
MatchesWithinNoise WithinNoise(const NormalizedProblem& space, const Estimate& estimate);

}  // namespace diffsac
