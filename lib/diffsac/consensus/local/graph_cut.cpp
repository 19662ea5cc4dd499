#include "diffsac/consensus/local/graph_cut.h"

#include <cmath>

#include "diffsac/consensus/samplers/neighbor_index.h"

namespace diffsac {
namespace {

Eigen::VectorXd Kernel(const Eigen::VectorXd& residuals, double threshold) {
  return (residuals.array() / threshold).square().unaryExpr([](double square) {
    // Written so that NaN is an outlier.
    return square >= 0.0 ? std::exp(-0.5 * square) : 0.0;
  });
}

}  // namespace

GraphCut::GraphCut(const PointMatrix& points, int neighbors, double spatial_weight)
    : size_(static_cast<int>(points.rows())),
      spatial_weight_(spatial_weight),
      edges_(NeighborEdges(points, neighbors)),
      cut_(size_, edges_) {}

std::vector<std::uint8_t> GraphCut::Label(const Eigen::VectorXd& residuals, double threshold) const {
  const Eigen::VectorXd kernel = Kernel(residuals, threshold);
  // The cost of label 1 over label 0. A pair costs R(0,0) + (1 − R(0,0)) x_i + (R(1,1) − 1) x_j + (1 − x_i) x_j, with
  // R(0,1) = R(1,0) = 1 and R(0,0) + R(1,1) = 1.
  Eigen::VectorXd cost = 1.0 - 2.0 * kernel.array();
  for (const auto& [i, j] : edges_) {
    const double both_out = 0.5 * (kernel[i] + kernel[j]);
    cost[i] += spatial_weight_ * (1.0 - both_out);
    cost[j] -= spatial_weight_ * both_out;
  }
  return cut_.Labels(cost, Eigen::VectorXd::Constant(static_cast<Eigen::Index>(edges_.size()), spatial_weight_));
}

double GraphCut::Energy(const Eigen::VectorXd& residuals, double threshold,
                        const std::vector<std::uint8_t>& labels) const {
  const Eigen::VectorXd kernel = Kernel(residuals, threshold);
  double energy = 0.0;
  for (int i = 0; i < size_; ++i) energy += labels[i] ? 1.0 - kernel[i] : kernel[i];
  for (const auto& [i, j] : edges_) {
    const double mean = 0.5 * (kernel[i] + kernel[j]);
    energy += spatial_weight_ * (labels[i] != labels[j] ? 1.0 : labels[i] ? 1.0 - mean : mean);
  }
  return energy;
}

}  // namespace diffsac
