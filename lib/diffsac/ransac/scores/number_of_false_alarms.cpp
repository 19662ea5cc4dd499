#include "diffsac/ransac/scores/number_of_false_alarms.h"

#include <algorithm>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace diffsac {
namespace {

// Of a probability; below it chance has nothing to say any more.
constexpr double kLeastTail = 1e-300;

double LogChoose(int n, int k) { return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0); }

}  // namespace

double Log10Nfa(int points, int inliers, int minimal_set, double share) {
  if (inliers <= minimal_set || points < inliers) return std::numeric_limits<double>::infinity();
  const double log = std::log(static_cast<double>(points - minimal_set)) + LogChoose(points, inliers) +
                     LogChoose(inliers, minimal_set) + (inliers - minimal_set) * std::log(share);
  return log / std::numbers::ln10;
}

double LogChanceModels(int points, int inliers, int minimal_set, double share) {
  if (inliers <= minimal_set || points < inliers) return std::numeric_limits<double>::infinity();
  // P(X >= k) of the binomial distribution is the regularised incomplete beta function.
  const double tail = share < 1.0 ? boost::math::ibeta(inliers - minimal_set, points - inliers + 1.0, share) : 1.0;
  return LogChoose(points, minimal_set) / std::numbers::ln10 + std::log10(std::max(tail, kLeastTail));
}

}  // namespace diffsac
