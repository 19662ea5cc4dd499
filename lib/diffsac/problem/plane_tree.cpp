#include "diffsac/problem/plane_tree.h"

#include <algorithm>

namespace diffsac {
namespace {

// Its square is kFar, and what it adds to coordinates of order one changes nothing.
constexpr double kFarCoordinate = 1e150;
// Places that go down the tree side by side, so that none waits for its own last step alone.
constexpr int kWalkers = 8;

}  // namespace

PlaneTree::PlaneTree(const PlanePoints& points) {
  const auto count = static_cast<int>(points.size());
  for (; count > kEight * leaves_; leaves_ *= 2) ++levels_;
  nodes_.resize(2 * leaves_);
  cuts_.resize(leaves_);
  leaf_.resize(leaves_);
  std::vector<Point> sorted(count);
  for (int i = 0; i < count; ++i) sorted[i] = {{points.x[i], points.y[i]}, static_cast<std::uint64_t>(i)};
  Build(1, sorted.data(), sorted.data() + count);
}

void PlaneTree::Build(int index, Point* begin, Point* end) {
  Node& node = nodes_[index];
  node.low[0] = node.high[0] = begin->at[0];
  node.low[1] = node.high[1] = begin->at[1];
  node.least = begin->number;
  for (const Point* p = begin + 1; p < end; ++p) {
    for (int k = 0; k < 2; ++k) {
      node.low[k] = std::min(node.low[k], p->at[k]);
      node.high[k] = std::max(node.high[k], p->at[k]);
    }
    node.least = std::min(node.least, p->number);
  }
  if (is_leaf(index)) return Fill(&leaf_[index - leaves_], begin, end);
  Point* const middle = begin + (end - begin) / 2;
  Split(index, begin, middle, end);
  Build(2 * index, begin, middle);
  Build(2 * index + 1, middle, end);
}

void PlaneTree::Split(int index, Point* begin, Point* middle, Point* end) {
  const Node& node = nodes_[index];
  const int axis = node.high[0] - node.low[0] >= node.high[1] - node.low[1] ? 0 : 1;
  std::nth_element(begin, middle, end, [axis](const Point& a, const Point& b) {
    return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.number < b.number;
  });
  double last = begin->at[axis];
  for (const Point* p = begin; p < middle; ++p) last = std::max(last, p->at[axis]);
  cuts_[index] = {last, axis};
}

std::vector<std::int32_t> PlaneTree::LeavesOf(const PlanePoints& places) const {
  const auto count = static_cast<int>(places.size());
  std::vector<std::int32_t> leaves(count);
  for (int first = 0; first < count; first += kWalkers) {
    double at[kWalkers][2];
    std::uint32_t index[kWalkers];
    for (int j = 0; j < kWalkers; ++j) {
      const int place = std::min(first + j, count - 1);
      at[j][0] = places.x[place], at[j][1] = places.y[place];
      index[j] = 1;
    }
    for (int level = 0; level < levels_; ++level)
      for (int j = 0; j < kWalkers; ++j) {
        const Cut& cut = cuts_[index[j]];
        index[j] = 2 * index[j] + (at[j][cut.axis] > cut.place ? 1U : 0U);
      }
    for (int j = 0; j < kWalkers && first + j < count; ++j) leaves[first + j] = static_cast<std::int32_t>(index[j]);
  }
  return leaves;
}

void PlaneTree::Fill(Leaf* leaf, const Point* begin, const Point* end) {
  for (int k = 0; k < kEight; ++k) {
    const bool filled = begin + k < end;
    leaf->x[k] = filled ? begin[k].at[0] : kFarCoordinate;
    leaf->y[k] = filled ? begin[k].at[1] : 0.0;
    leaf->number[k] = filled ? begin[k].number : 0;
  }
}

}  // namespace diffsac
