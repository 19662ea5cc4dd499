#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "diffsac/geometry/points.h"

namespace diffsac {

/// The labels x of 0 and 1 that minimise
///   Σ_i cost_i x_i + Σ_k pair_cost_k (1 − x_first(k)) x_second(k),   pair_cost ≥ 0,
/// over the edges {first, second} of one graph, as a minimum cut (Kolmogorov and Zabih, PAMI 2004; maximum flow by
/// Boykov and Kolmogorov, PAMI 2004). Costs are compared to within 6e-8 of 1. The graph is built once for many cuts;
/// `Labels` may run in several threads at once.
class MinimumCut {
 public:
  MinimumCut(int size, const std::vector<std::pair<int, int>>& edges);
  ~MinimumCut();
  MinimumCut(MinimumCut&&) noexcept;
  /// cost: one a point; pair_cost: one an edge.
  std::vector<std::uint8_t> Labels(const Eigen::VectorXd& cost, const Eigen::VectorXd& pair_cost) const;

 private:
  int size_;
  struct Arcs;
  std::unique_ptr<const Arcs> arcs_;
};

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

 private:
  double spatial_weight_;
  std::vector<std::pair<int, int>> edges_;
  MinimumCut cut_;
};

}  // namespace diffsac
