#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/estimate/diffsac_model.h"
#include "diffsac/problem/point_features.h"

namespace diffsac {

/// The points of a problem that a network is shown, where it is not shown all.
class EncodedPoints {
 public:
  /// The `count` points of highest prior. Borrows nothing.
  void Choose(const Eigen::VectorXf& prior, int count, const FeatureSet& all);
  bool chosen() const { return !rows_.empty(); }
  const FeatureSet& features() const { return features_; }

  /// What was said of these points becomes what is said of all: the others weigh what their prior says, scaled to what
  /// the network says of the chosen ones, and have no confidence in any copy (−∞).
  void GiveToAll(Denoised* said) const;

 private:
  std::vector<int> rows_;
  Eigen::VectorXf prior_;
  FeatureSet features_;
};

}  // namespace diffsac
