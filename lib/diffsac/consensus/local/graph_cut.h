#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "diffsac/consensus/local/minimum_cut.h"
#include "diffsac/geometry/points.h"

namespace diffsac {

/// Labels points as inliers of a model by an energy that also asks neighbours to agree (Barath and Matas, "Graph-cut
/// RANSAC", CVPR 2018, section 3). With K_i = exp(−r_i²/2ε²), label 1 an inlier, and λ the weight of agreement:
///   E = Σ_i [L_i = 0] K_i + [L_i = 1] (1 − K_i) + λ Σ_(i,j) R,
///   R = 1 where L_i ≠ L_j, (K_i + K_j)/2 where both are 0, 1 − (K_i + K_j)/2 where both are 1.
/// The energy is submodular, so one minimum cut finds its minimum.
class GraphCut {
 public:
  /// Neighbours: each point and its `neighbors` nearest in all coordinates. spatial_weight: λ ≥ 0.
  GraphCut(const PointMatrix& points, int neighbors, double spatial_weight);
  /// Labels of least energy; threshold: ε. Energies are compared to within 1e-6 of a point's.
  std::vector<std::uint8_t> Label(const Eigen::VectorXd& residuals, double threshold) const;
  /// The energy of any labels.
  double Energy(const Eigen::VectorXd& residuals, double threshold, const std::vector<std::uint8_t>& labels) const;

 private:
  int size_;
  double spatial_weight_;
  std::vector<std::pair<int, int>> edges_;
  MinimumCut cut_;
};

}  // namespace diffsac
