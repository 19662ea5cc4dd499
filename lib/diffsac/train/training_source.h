#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "diffsac/data/labels.h"
#include "diffsac/data/point_features.h"
#include "diffsac/data/problem.h"

namespace diffsac {

/// One problem with everything a training step draws for it.
struct TrainingItem {
  FeatureSet features;
  std::vector<float> inliers;   ///< N, 1 for a true inlier
  std::vector<float> labels;    ///< copies × N, ±1
  std::vector<float> noise;     ///< copies × N, standard normal
  std::vector<int> times;       ///< copies, uniform in [0, T)
};

/// Makes item `index` of a training run: a function of (seed, index) alone, so that resuming needs only a number.
class TrainingSource {
 public:
  TrainingSource(const Dataset& dataset, PointFeatures features, LabelOptions labels, int copies, int schedule_steps,
                 std::uint64_t seed);
  TrainingItem Make(std::uint64_t index) const;

 private:
  const Dataset& dataset_;
  PointFeatures features_;
  LabelOptions labels_;
  int copies_;
  int schedule_steps_;
  Rng rng_;
};

}  // namespace diffsac
