#include "diffsac/consensus/false_alarms.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace diffsac {
namespace {

double LogChoose(int n, int k) { return std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0); }

}  // namespace

double LogFalseAlarms(int points, int inliers, int minimal_set, double share) {
  if (inliers <= minimal_set || points < inliers) return std::numeric_limits<double>::infinity();
  const double log = std::log(static_cast<double>(points - minimal_set)) + LogChoose(points, inliers) +
                     LogChoose(inliers, minimal_set) + (inliers - minimal_set) * std::log(share);
  return log / std::numbers::ln10;
}

}  // namespace diffsac
