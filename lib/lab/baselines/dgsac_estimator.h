#pragma once

#include <string>

#include "diffsac/estimators/robust_estimator.h"
#include "lab/baselines/dgsac.h"

namespace diffsac {

/// kDensity: the model is DGSAC's own, found without the problem's inlier threshold | kConsensus: it then passes the
/// local optimisation and the refits of `consensus`, which use the threshold, as the other rows' models do.
enum class DgsacFinish { kDensity, kConsensus };
template <>
inline constexpr auto kEnumNames<DgsacFinish> = NamesOf<DgsacFinish>({{DgsacFinish::kDensity, "density"},
                                                                      {DgsacFinish::kConsensus, "consensus"}});

/// Options of the row `dgsac`.
struct DgsacEstimatorOptions {
  DgsacOptions search;
  DgsacFinish finish = DgsacFinish::kDensity;
  ConsensusOptions consensus;
  void Bind(OptionsBinder& b);
};

/// Defaults: `consensus` as in `lo_ransac` rows (classical.h), for all models.
DgsacEstimatorOptions DefaultDgsacOptions(Task task);

/// DGSAC as a row (dgsac.h): its multi-structure result becomes one model by `choose`. The mask
/// that is reported is at the problem's threshold, as every row's; the score is the inlier count.
class DgsacEstimator : public RobustEstimator {
 public:
  explicit DgsacEstimator(const DgsacEstimatorOptions& options) : options_(options) { CheckOptions(options); }
  Estimate DoRun(const Problem& problem, std::uint64_t seed) const override;

 private:
  DgsacEstimatorOptions options_;
};

}  // namespace diffsac
