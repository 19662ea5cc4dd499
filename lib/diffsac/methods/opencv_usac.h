#pragma once

#include <string>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// OpenCV's estimators on the same problems with the same budget: the independent reference of the two-view tables.
struct OpencvUsacOptions {
  int hypotheses = 1000;  ///< OpenCV's maxIters; it may stop earlier by its confidence.
  double confidence = 0.9999;
  /// "default" | "fast" | "accurate" | "prosac" | "magsac" | "parallel" | "fm_8pts" | "ransac": OpenCV's USAC_* and
  /// RANSAC flags. `prosac` gets the correspondences sorted by quality, best first.
  std::string preset = "default";
  void Bind(OptionsBinder& b);
};

/// cv::findHomography, cv::findFundamentalMat, cv::findEssentialMat. The essential matrix is estimated in normalised
/// coordinates with the threshold divided by the mean focal length. OpenCV's own seed is fixed, so `seed` changes
/// nothing; its report gives no number of hypotheses, so the budget stands there. An exception inside OpenCV is
/// kNoModel.
class OpencvUsacMethod : public Method {
 public:
  explicit OpencvUsacMethod(const OpencvUsacOptions& options) : options_(options) {}
  diffsac::Estimate Estimate(const Problem& problem, std::uint64_t seed) const override;

 private:
  OpencvUsacOptions options_;
};

/// The rows of a problem, the best quality first where that is asked for and known.
std::vector<int> OpencvOrder(const Problem& problem, bool by_quality);

}  // namespace diffsac
