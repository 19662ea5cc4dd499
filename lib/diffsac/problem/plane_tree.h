#pragma once

#include <cstdint>
#include <vector>

#include "diffsac/problem/nearest_eight.h"

namespace diffsac {

/// A balanced k-d tree of points in a plane, each leaf of 4 to 8. Nodes are numbered as in a heap: the root is 1, the
/// children of n are 2n and 2n + 1, the last `leaves` nodes are the leaves. Which points a node holds depends on where
/// they lie and, where they tie, on their numbers: the lower ones go first.
class PlaneTree {
 public:
  /// Squared distance of what fills a leaf that holds less than eight.
  static constexpr double kFar = 1e300;

  struct Leaf {
    double x[kEight], y[kEight];
    std::uint64_t number[kEight];
  };
  struct Node {
    double low[2], high[2];  ///< The points' bounding box.
    std::uint64_t least;     ///< Their least number.
  };
  /// Of an inner node: points whose coordinate is at most `place` go to the left child.
  struct Cut {
    double place;
    std::int64_t axis;
  };

  /// At least 9 points, of coordinates up to about 1.
  explicit PlaneTree(const PlanePoints& points);

  int leaves() const { return leaves_; }
  const Node& node(int index) const { return nodes_[index]; }
  const Cut& cut(int index) const { return cuts_[index]; }
  bool is_leaf(int index) const { return index >= leaves_; }
  const Leaf& leaf(int index) const { return leaf_[index - leaves_]; }
  /// The leaves (numbers among the nodes) in whose regions the places are.
  std::vector<std::int32_t> LeavesOf(const PlanePoints& places) const;

 private:
  struct Point {
    double at[2];
    std::uint64_t number;
  };
  void Build(int index, Point* begin, Point* end);
  void Split(int index, Point* begin, Point* middle, Point* end);
  void Fill(Leaf* leaf, const Point* begin, const Point* end);

  int leaves_ = 1;
  int levels_ = 0;  // below the root
  std::vector<Node> nodes_;
  std::vector<Cut> cuts_;
  std::vector<Leaf> leaf_;
};

}  // namespace diffsac
