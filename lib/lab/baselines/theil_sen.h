#pragma once

#include "diffsac/core/options.h"
#include "diffsac/estimators/robust_estimator.h"

namespace diffsac {

struct TheilSenOptions {
  /// Most minimal sets to solve. All of them are, when there are no more than this; otherwise this many random ones.
  int max_iterations = 20000;
  void Bind(OptionsBinder& b);
};

/// Theil–Sen. Lines: the median slope of all pairs and the median of y − slope·x (Theil 1950; Sen, JASA 1968). Planes:
/// z = a x + b y + c with the coordinate-wise medians of (a, b) over triplets and the median of z − a x − b y, the
/// coordinate-wise form of multivariate Theil–Sen (Dang, Peng, Wang, Zhang, "Theil–Sen estimators in a multiple linear
/// regression model", 2008).
///
/// Not invariant to rotation: errors are taken along the last axis, sets that are parallel to it are left out, and the
/// breakdown point is 29 % for lines. It is here because the paper's tables have it as a row.
/// kNoModel when every set is parallel to the last axis. The score is the inlier count.
class TheilSenEstimator : public RobustEstimator {
 public:
  explicit TheilSenEstimator(const TheilSenOptions& options) : options_(options) { CheckOptions(options); }
  Estimate DoRun(const Problem& problem, std::uint64_t seed) const override;

 private:
  TheilSenOptions options_;
};

}  // namespace diffsac
