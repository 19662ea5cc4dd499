#include "diffsac/consensus/graph_cut.h"

#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/property_map/property_map.hpp>
#include <cmath>

#include "diffsac/consensus/neighbor_index.h"

namespace diffsac {
namespace {

using Capacity = std::int64_t;
/// Whole capacities: augmenting paths then end after finitely many steps with an exact minimum.
constexpr double kUnit = 1 << 24;

using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;

struct Arc {
  Capacity capacity = 0;
  Capacity residual = 0;
  Traits::edge_descriptor reverse;
};

struct Node {
  boost::default_color_type color = boost::white_color;
  long distance = 0;
  Traits::edge_descriptor predecessor;
};

using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, Node, Arc>;

void AddArcs(Graph* graph, int from, int to, Capacity forward, Capacity backward) {
  const auto there = boost::add_edge(from, to, *graph).first;
  const auto back = boost::add_edge(to, from, *graph).first;
  (*graph)[there].capacity = forward;
  (*graph)[back].capacity = backward;
  (*graph)[there].reverse = back;
  (*graph)[back].reverse = there;
}

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
      edges_(NeighborEdges(points, neighbors)) {}

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
  Graph graph(size_ + 2);
  const int source = size_, sink = size_ + 1;
  for (int i = 0; i < size_; ++i) {
    const auto capacity = static_cast<Capacity>(std::llround(std::abs(cost[i]) * kUnit));
    // The source's side is label 1.
    if (cost[i] > 0.0)
      AddArcs(&graph, i, sink, capacity, 0);
    else
      AddArcs(&graph, source, i, capacity, 0);
  }
  const auto weight = static_cast<Capacity>(std::llround(spatial_weight_ * kUnit));
  for (const auto& [i, j] : edges_) AddArcs(&graph, j, i, weight, 0);
  boost::boykov_kolmogorov_max_flow(graph, boost::get(&Arc::capacity, graph), boost::get(&Arc::residual, graph),
                                    boost::get(&Arc::reverse, graph), boost::get(&Node::predecessor, graph),
                                    boost::get(&Node::color, graph), boost::get(&Node::distance, graph),
                                    boost::get(boost::vertex_index, graph), source, sink);
  std::vector<std::uint8_t> labels(size_);
  const auto source_color = graph[source].color;
  for (int i = 0; i < size_; ++i) labels[i] = graph[i].color == source_color ? 1 : 0;
  return labels;
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
