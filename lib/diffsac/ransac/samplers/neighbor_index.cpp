#include "diffsac/ransac/samplers/neighbor_index.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <nanoflann.hpp>
#include <numeric>

namespace diffsac {
namespace {

/// Brings values to order one, so that squared distances stay finite; a power of two, so that their order is the same.
double Scale(const PointMatrix& points) {
  constexpr int kLeastExponent = -1000;
  if (points.size() == 0) return 1.0;
  int exponent = 0;
  std::frexp(points.cwiseAbs().maxCoeff(), &exponent);
  return std::ldexp(1.0, -std::max(exponent, kLeastExponent));
}

/// nanoflann's view of the points.
struct Cloud {
  PointMatrix points;
  std::size_t kdtree_get_point_count() const { return static_cast<std::size_t>(points.rows()); }
  double kdtree_get_pt(std::size_t row, std::size_t column) const {
    return points(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, -1, std::size_t>;
constexpr int kLeafSize = 16;

}  // namespace

struct NeighborIndex::Impl {
  explicit Impl(const PointMatrix& points)
      : scale(Scale(points)),
        cloud{points * scale},
        tree(static_cast<int>(points.cols()), cloud, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {
    tree.buildIndex();
  }
  /// The `count` nearest to a scaled place, with their squared distances; ties are not in order yet.
  std::vector<std::pair<double, int>> Find(const double* place, int count) const {
    std::vector<std::size_t> found(count);
    std::vector<double> distances(count);
    nanoflann::KNNResultSet<double> results(found.size());
    results.init(found.data(), distances.data());
    tree.findNeighbors(results, place, {});
    std::vector<std::pair<double, int>> nearest;
    nearest.reserve(results.size());
    for (std::size_t i = 0; i < results.size(); ++i) nearest.emplace_back(distances[i], static_cast<int>(found[i]));
    std::sort(nearest.begin(), nearest.end());
    return nearest;
  }

  double scale;
  Cloud cloud;
  Tree tree;
};

NeighborIndex::NeighborIndex(const PointMatrix& points) : impl_(std::make_unique<Impl>(points)) {}
NeighborIndex::~NeighborIndex() = default;
NeighborIndex::NeighborIndex(NeighborIndex&&) noexcept = default;

int NeighborIndex::size() const { return static_cast<int>(impl_->cloud.points.rows()); }

std::vector<int> NeighborIndex::Nearest(int index, int count) const {
  count = std::min(count, size() - 1);
  if (count < 1) return {};
  // One more, because the point finds itself.
  std::vector<int> nearest;
  for (const auto& [distance, other] : impl_->Find(impl_->cloud.points.row(index).data(), count + 1))
    if (other != index) nearest.push_back(other);
  // Where many points coincide the point itself may not be among those found.
  nearest.resize(std::min<std::size_t>(nearest.size(), count));
  return nearest;
}

std::vector<int> NeighborIndex::NearestTo(const double* place, int count) const {
  count = std::min(count, size());
  if (count < 1) return {};
  const Eigen::RowVectorXd scaled =
      impl_->scale * Eigen::Map<const Eigen::RowVectorXd>(place, impl_->cloud.points.cols());
  std::vector<int> nearest;
  nearest.reserve(count);
  for (const auto& [distance, point] : impl_->Find(scaled.data(), count)) nearest.push_back(point);
  return nearest;
}

std::vector<std::pair<int, int>> NeighborEdges(const PointMatrix& points, int count) {
  const NeighborIndex index(points);
  std::vector<std::pair<int, int>> edges;
  for (int i = 0; i < index.size(); ++i)
    for (int other : index.Nearest(i, count)) edges.emplace_back(std::min(i, other), std::max(i, other));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

Eigen::VectorXd NeighborhoodSupport(const PointMatrix& matches, int neighbors) {
  constexpr double kSharedOfRight = 0.5;
  Eigen::VectorXd support = Eigen::VectorXd::Zero(matches.rows());
  if (matches.rows() < 2 * neighbors) return support;
  const NeighborIndex first(matches.leftCols(2)), second(matches.rightCols(2));
  const double by_chance = std::min(kSharedOfRight, neighbors / static_cast<double>(matches.rows() - 1));
  const double shared = std::log(kSharedOfRight / by_chance);
  const double other = std::log((1.0 - kSharedOfRight) / (1.0 - by_chance));
  for (int i = 0; i < first.size(); ++i) {
    std::vector<int> here = first.Nearest(i, neighbors), there = second.Nearest(i, neighbors), both;
    std::sort(here.begin(), here.end());
    std::sort(there.begin(), there.end());
    std::set_intersection(here.begin(), here.end(), there.begin(), there.end(), std::back_inserter(both));
    const auto count = static_cast<int>(both.size());
    support[i] = count * shared + (neighbors - count) * other;
  }
  return support;
}

}  // namespace diffsac
