#include "diffsac/consensus/local/minimum_cut.h"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/property_map/property_map.hpp>
#include <cmath>
#include <tuple>

namespace diffsac {
namespace {

using Capacity = std::int64_t;
/// Whole capacities: augmenting paths then end after finitely many steps with an exact minimum.
constexpr double kUnit = 1 << 24;

using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                 boost::no_property, int, int>;
using Arc = boost::graph_traits<Graph>::edge_descriptor;

Capacity Whole(double cost) { return static_cast<Capacity>(std::llround(cost * kUnit)); }

}  // namespace

/// Every point with arcs from the sampler and to the sink, neighbours with arcs both ways, and each arc's reverse: what
/// is the same in all cuts. Arcs that a cut does not need have no capacity.
struct MinimumCut::Arcs {
  Arcs(int size, const std::vector<std::pair<int, int>>& edges)
      : from_source(size), to_sink(size), pairs(edges.size()) {
    const int sampler = size, sink = size + 1;
    // From, to, and where the arc's place among all is kept; none for reverse arcs.
    std::vector<std::tuple<int, int, int*>> arcs;
    arcs.reserve(4 * from_source.size() + 2 * edges.size());
    const auto add = [&](int from, int to, int* place) {
      arcs.emplace_back(from, to, place);
      arcs.emplace_back(to, from, nullptr);
    };
    for (int i = 0; i < size; ++i) {
      add(sampler, i, &from_source[i]);
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
  const int sampler = size_, sink = size_ + 1;
  std::vector<Capacity> capacity(arcs_->reverse.size(), 0), residual(capacity.size(), 0);
  for (int i = 0; i < size_; ++i)
    // The sampler's side is label 1.
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
                                    of_nodes(predecessor), of_nodes(color), of_nodes(distance), node_index, sampler,
                                    sink);
  std::vector<std::uint8_t> labels(size_);
  for (int i = 0; i < size_; ++i) labels[i] = color[i] == color[sampler] ? 1 : 0;
  return labels;
}

}  // namespace diffsac
