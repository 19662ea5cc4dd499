#include "diffsac/ransac/local/graph_cut.h"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/property_map/property_map.hpp>
#include <cmath>
#include <tuple>

#include "diffsac/ransac/samplers/neighbor_index.h"

namespace diffsac {
namespace {

using Capacity = std::int64_t;
/// Whole capacities: augmenting paths then end after finitely many steps with an exact minimum.
constexpr double kUnit = 1 << 24;

using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                 boost::no_property, int, int>;
using Arc = boost::graph_traits<Graph>::edge_descriptor;

Capacity Whole(double cost) { return static_cast<Capacity>(std::llround(cost * kUnit)); }

Eigen::VectorXd Kernel(const Eigen::VectorXd& residuals, double threshold) {
  return (residuals.array() / threshold).square().unaryExpr([](double square) {
    // Written so that NaN is an outlier.
    return square >= 0.0 ? std::exp(-0.5 * square) : 0.0;
  });
}

}  // namespace

/// Every point with arcs from the source and to the sink, neighbours with arcs both ways, and each arc's reverse: what
/// is the same in all cuts. Arcs that a cut does not need have no capacity.
struct MinimumCut::Arcs {
  Arcs(int size, const std::vector<std::pair<int, int>>& edges)
      : from_source(size), to_sink(size), pairs(edges.size()) {
    const int source = size, sink = size + 1;
    // From, to, and where the arc's place among all is kept; none for reverse arcs.
    std::vector<std::tuple<int, int, int*>> arcs;
    arcs.reserve(4 * from_source.size() + 2 * edges.size());
    const auto add = [&](int from, int to, int* place) {
      arcs.emplace_back(from, to, place);
      arcs.emplace_back(to, from, nullptr);
    };
    for (int i = 0; i < size; ++i) {
      add(source, i, &from_source[i]);
      add(i, sink, &to_sink[i]);
    }
    for (std::size_t k = 0; k < edges.size(); ++k) add(edges[k].second, edges[k].first, &pairs[k]);
    const auto ends = [](const auto& arc) { return std::pair(std::get<0>(arc), std::get<1>(arc)); };
    std::sort(arcs.begin(), arcs.end(), [&](const auto& a, const auto& b) { return ends(a) < ends(b); });
    std::vector<std::pair<int, int>> sorted;
    sorted.reserve(arcs.size());
    for (const auto& arc : arcs) sorted.push_back(ends(arc));
    graph = Graph(boost::edges_are_sorted, sorted.begin(), sorted.end(), size + 2);
    reverse.reserve(arcs.size());
    for (std::size_t k = 0; k < arcs.size(); ++k) {
      const auto [from, to] = sorted[k];
      const auto back = std::lower_bound(sorted.begin(), sorted.end(), std::pair(to, from)) - sorted.begin();
      reverse.emplace_back(to, static_cast<int>(back));
      if (std::get<2>(arcs[k]) != nullptr) *std::get<2>(arcs[k]) = static_cast<int>(k);
    }
  }

  Graph graph;
  std::vector<Arc> reverse;                      ///< of each arc
  std::vector<int> from_source, to_sink, pairs;  ///< of each point, and of each pair of neighbours, the arc
};

MinimumCut::MinimumCut(int size, const std::vector<std::pair<int, int>>& edges)
    : size_(size), arcs_(std::make_unique<Arcs>(size, edges)) {}
MinimumCut::~MinimumCut() = default;
MinimumCut::MinimumCut(MinimumCut&&) noexcept = default;

std::vector<std::uint8_t> MinimumCut::Labels(const Eigen::VectorXd& cost, const Eigen::VectorXd& pair_cost) const {
  const std::size_t nodes = static_cast<std::size_t>(size_) + 2;
  const int source = size_, sink = size_ + 1;
  std::vector<Capacity> capacity(arcs_->reverse.size(), 0), residual(capacity.size(), 0);
  for (int i = 0; i < size_; ++i)
    // The source's side is label 1.
    capacity[(cost[i] > 0.0 ? arcs_->to_sink : arcs_->from_source)[i]] = Whole(std::abs(cost[i]));
  for (std::size_t k = 0; k < arcs_->pairs.size(); ++k)
    capacity[arcs_->pairs[k]] = Whole(pair_cost[static_cast<Eigen::Index>(k)]);
  std::vector<boost::default_color_type> color(nodes, boost::white_color);
  std::vector<long> distance(nodes, 0);
  std::vector<Arc> predecessor(nodes);
  const auto arc_index = boost::get(boost::edge_index, arcs_->graph);
  const auto node_index = boost::get(boost::vertex_index, arcs_->graph);
  const auto of_arcs = [&](auto& values) { return boost::make_iterator_property_map(values.begin(), arc_index); };
  const auto of_nodes = [&](auto& values) { return boost::make_iterator_property_map(values.begin(), node_index); };
  boost::boykov_kolmogorov_max_flow(arcs_->graph, of_arcs(capacity), of_arcs(residual), of_arcs(arcs_->reverse),
                                    of_nodes(predecessor), of_nodes(color), of_nodes(distance), node_index, source,
                                    sink);
  std::vector<std::uint8_t> labels(size_);
  for (int i = 0; i < size_; ++i) labels[i] = color[i] == color[source] ? 1 : 0;
  return labels;
}

GraphCut::GraphCut(const PointMatrix& points, int neighbors, double spatial_weight)
    : spatial_weight_(spatial_weight),
      edges_(NeighborEdges(points, neighbors)),
      cut_(static_cast<int>(points.rows()), edges_) {}

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

}  // namespace diffsac
