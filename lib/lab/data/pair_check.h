#pragma once

#include <string>
#include <vector>

#include "lab/data/pair_dataset.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// Counts what makes pairs of a scene unfit to teach or to measure, as its files hold them.
class PairCheck {
 public:
  explicit PairCheck(const PairsOptions& options) : options_(options) {}

  /// A pair of no task yet.
  void Add(const Example& pair);

  /// Warns, once for a folder: hardly any matches near the truth, or no right match in many pairs;
  /// pairs without baseline. Throws Error for ratios outside [0, 1].
  void Tell(const std::string& folder) const;

 private:
  void AddNear(const Example& pair);

  PairsOptions options_;
  int pairs_ = 0, without_baseline_ = 0, measured_ = 0, without_right_ = 0;
  std::int64_t ratios_ = 0, bad_ratios_ = 0, matches_ = 0, near_ = 0;
  std::string files_;  // Of the truth.
};

/// Warns, once for a folder, of pairs of files whose model, pose and inliers are all unknown: nothing can be measured.
void WarnOfMissingTruth(const Dataset& dataset);

}  // namespace diffsac
