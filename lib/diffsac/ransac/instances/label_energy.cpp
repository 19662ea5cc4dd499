#include "diffsac/ransac/instances/label_energy.h"

#include "diffsac/ransac/samplers/neighbor_index.h"

namespace diffsac {

LabelEnergy::LabelEnergy(const PointMatrix& points, int neighbors, double spatial_weight, double model_cost,
                         Eigen::VectorXd outlier_costs)
    : outlier_costs_(std::move(outlier_costs)),
      spatial_weight_(spatial_weight),
      model_cost_(model_cost),
      edges_(NeighborEdges(points, neighbors)),
      cut_(static_cast<int>(points.rows()), edges_) {}

double LabelEnergy::Value(const ModelCosts& costs, const Labels& labels) const {
  double value = 0.0;
  std::vector<std::uint8_t> used(costs.size() + 1, 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    value += PointCost(costs, labels[i], static_cast<Eigen::Index>(i));
    used[labels[i]] = 1;
  }
  for (const auto& [i, j] : edges_) value += labels[i] != labels[j] ? spatial_weight_ : 0.0;
  for (std::size_t k = 1; k < used.size(); ++k) value += used[k] ? model_cost_ : 0.0;
  return value;
}

void LabelEnergy::Expand(const ModelCosts& costs, std::int32_t label, Labels* labels) const {
  const auto size = static_cast<Eigen::Index>(labels->size());
  Eigen::VectorXd cost(size), pair_cost(static_cast<Eigen::Index>(edges_.size()));
  for (Eigen::Index i = 0; i < size; ++i) cost[i] = PointCost(costs, label, i) - PointCost(costs, (*labels)[i], i);
  // With x = 1 for the label, a pair costs stay (0,0), first (0,1) where the second alone takes it, second (1,0), and
  // nothing (1,1): stay + (second − stay) x_i − second x_j + (first + second − stay) (1 − x_i) x_j.
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    const auto [i, j] = edges_[k];
    const auto differ = [&](std::int32_t a, std::int32_t b) { return a != b ? spatial_weight_ : 0.0; };
    const double stay = differ((*labels)[i], (*labels)[j]);
    const double first = differ((*labels)[i], label), second = differ((*labels)[j], label);
    cost[i] += second - stay;
    cost[j] -= second;
    pair_cost[static_cast<Eigen::Index>(k)] = first + second - stay;
  }
  const std::vector<std::uint8_t> takes = cut_.Labels(cost, pair_cost);
  for (std::size_t i = 0; i < labels->size(); ++i)
    if (takes[i]) (*labels)[i] = label;
}

double LabelEnergy::ExpandAll(const ModelCosts& costs, Labels* labels) const {
  constexpr double kLeastGain = 1e-6;
  double energy = Value(costs, *labels);
  for (int round = 0; round < kMostRounds; ++round) {
    const double before = energy;
    for (std::int32_t label = 0; label <= static_cast<std::int32_t>(costs.size()); ++label) {
      Labels moved = *labels;
      Expand(costs, label, &moved);
      const double value = Value(costs, moved);
      if (!(value < energy - kLeastGain)) continue;
      energy = value;
      *labels = std::move(moved);
    }
    if (!(energy < before)) break;
  }
  return energy;
}

}  // namespace diffsac
