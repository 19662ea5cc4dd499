#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "diffsac/geometry/points.h"
#include "diffsac/ransac/local/graph_cut.h"

namespace diffsac {

/// The energy of giving each point one of several models, or none, after Isack and Boykov ("Energy-based geometric
/// multi-model fitting", IJCV 2012) and Delong et al. ("Fast approximate energy minimization with label costs", IJCV
/// 2012):
///   E(L) = Σ_i D_i(L_i) + λ |{neighbours with other labels}| + h |{models that have a point}|,
/// D_i(0) the cost of being an outlier, D_i(k) that of model k − 1.
class LabelEnergy {
 public:
  using Labels = std::vector<std::int32_t>;
  using ModelCosts = std::vector<Eigen::VectorXd>;  ///< Of each model, N values.

  /// Neighbours: each point and its `neighbors` nearest in all coordinates. spatial_weight: λ ≥ 0; model_cost: h ≥ 0.
  LabelEnergy(const PointMatrix& points, int neighbors, double spatial_weight, double model_cost,
              Eigen::VectorXd outlier_costs);

  double Value(const ModelCosts& costs, const Labels& labels) const;
  double PointCost(const ModelCosts& costs, std::int32_t label, Eigen::Index point) const {
    return label == 0 ? outlier_costs_[point] : costs[static_cast<std::size_t>(label - 1)][point];
  }

  /// The expansion move (Boykov, Veksler and Zabih, PAMI 2001): those points take `label` for which, all together, the
  /// energy but for h is least.
  void Expand(const ModelCosts& costs, std::int32_t label, Labels* labels) const;
  /// Expansions of every label in turn, kept where they lower the energy, until none does or kMostRounds. Returns the
  /// energy.
  double ExpandAll(const ModelCosts& costs, Labels* labels) const;
  static constexpr int kMostRounds = 5;

 private:
  Eigen::VectorXd outlier_costs_;
  double spatial_weight_, model_cost_;
  std::vector<std::pair<int, int>> edges_;
  MinimumCut cut_;
};

}  // namespace diffsac
