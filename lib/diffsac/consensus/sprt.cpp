#include "diffsac/consensus/sprt.h"

#include <cmath>
#include <limits>

namespace diffsac {
namespace {

/// The cost of solving one minimal set, in residuals.
constexpr double kSolveCost = 100.0;
/// δ is taken over when it has moved by this share, so that the test does not change with every model.
constexpr double kNotable = 0.05;
constexpr double kLeastShare = 1e-4, kMostShare = 0.999;
/// Points looked at in dropped models before δ is estimated from them.
constexpr double kFewest = 100.0;

}  // namespace

SequentialTest::SequentialTest(int solutions_per_set) : solutions_per_set_(solutions_per_set) { Design(); }

void SequentialTest::Design() {
  if (!(bad_share_ < 0.9 * good_share_)) {
    // Good and bad models look alike: nothing is dropped.
    inlier_factor_ = outlier_factor_ = 1.0;
    decision_threshold_ = std::numeric_limits<double>::infinity();
    return;
  }
  inlier_factor_ = bad_share_ / good_share_;
  outlier_factor_ = (1.0 - bad_share_) / (1.0 - good_share_);
  const double information = (1.0 - bad_share_) * std::log(outlier_factor_) + bad_share_ * std::log(inlier_factor_);
  const double base = kSolveCost * information / solutions_per_set_ + 1.0;
  decision_threshold_ = base;
  for (int i = 0; i < 10; ++i) decision_threshold_ = base + std::log(decision_threshold_);
}

bool SequentialTest::AddRejected(const Outcome& outcome) {
  tested_ += outcome.tested;
  tested_inliers_ += outcome.inliers;
  const double share = std::clamp(tested_inliers_ / tested_, kLeastShare, kMostShare);
  if (tested_ < kFewest || std::abs(share - bad_share_) <= kNotable * bad_share_) return false;
  bad_share_ = share;
  Design();
  return true;
}

bool SequentialTest::AddBest(double inlier_share) {
  const double share = std::min(inlier_share, kMostShare);
  if (!(share > good_share_)) return false;
  good_share_ = share;
  Design();
  return true;
}

double SequentialTest::PassProbability() const {
  return std::isinf(decision_threshold_) ? 1.0 : 1.0 - 1.0 / decision_threshold_;
}

}  // namespace diffsac
