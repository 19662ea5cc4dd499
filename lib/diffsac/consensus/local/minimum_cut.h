#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

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

}  // namespace diffsac
