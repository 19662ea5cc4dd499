#pragma once

#include <vector>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/options/options.h"

namespace diffsac {

/// OpenCV's flags by their values there: USAC_*, RANSAC and LMEDS (which knows no threshold). kProsac gets the
/// correspondences sorted by quality, best first.
enum class OpencvPreset {
  kLmeds = 4,
  kRansac = 8,
  kDefault = 32,
  kParallel,
  kFundamental8,
  kFast,
  kAccurate,
  kProsac,
  kMagsac
};
template <>
inline constexpr auto kEnumNames<OpencvPreset> = NamesOf<OpencvPreset>({{OpencvPreset::kDefault, "default"},
                                                                        {OpencvPreset::kFast, "fast"},
                                                                        {OpencvPreset::kAccurate, "accurate"},
                                                                        {OpencvPreset::kProsac, "prosac"},
                                                                        {OpencvPreset::kMagsac, "magsac"},
                                                                        {OpencvPreset::kParallel, "parallel"},
                                                                        {OpencvPreset::kFundamental8, "fm_8pts"},
                                                                        {OpencvPreset::kRansac, "ransac"},
                                                                        {OpencvPreset::kLmeds, "lmeds"}});

/// When OpenCV stops.
struct OpencvOptions {
  int max_iterations = 1000;
  double confidence = 0.9999;
  void Bind(OptionsBinder& b);
};

/// OpenCV's estimators on the same problems with the same budget: the independent reference of the two-view tables.
struct OpencvUsacOptions : OpencvOptions {
  double threshold = 0.0;
  OpencvPreset preset = OpencvPreset::kDefault;
  void Bind(OptionsBinder& b);
};

/// cv::findHomography, cv::findFundamentalMat, cv::findEssentialMat. The essential matrix is estimated in normalised
/// coordinates with the threshold divided by the mean focal length. OpenCV's own seed is fixed, so `seed` changes
/// nothing; its report gives no number of hypotheses, so the budget stands there. An exception inside OpenCV is
/// kNoModel; of more than 46 340 matches `accurate` is kTooManyPoints.
class OpencvUsacEstimator : public RobustEstimator {
 public:
  explicit OpencvUsacEstimator(const OpencvUsacOptions& options) : options_(options) { CheckOptions(options); }
  Estimate DoRun(const NormalizedProblem& space, std::uint64_t seed) const override;

 private:
  OpencvUsacOptions options_;
};

/// The rows of a problem, the best quality first where that is asked for and known.
std::vector<int> OpencvOrder(const Problem& problem, bool by_quality);

}  // namespace diffsac
