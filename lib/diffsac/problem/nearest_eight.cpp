#include "diffsac/problem/nearest_eight.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "diffsac/geometry/vector_clones.h"
#include "diffsac/problem/neighbor_lanes.h"
#include "diffsac/problem/plane_tree.h"

namespace diffsac {
namespace {

// Parts of a leaf's region by which the places in it are put in order.
constexpr int kParts = 4;
// No key is a subnormal number, which some modes of the processor take for 0.
constexpr double kLeastDistance = 1e-290;

// Places that lie near each other, each with its best so far as keys in ascending order: a squared distance whose
// lowest bits are the point's number. Keys are compared as numbers, so that a minimum takes the number along.
struct Group {
  double x[kLanes], y[kLanes];
  std::uint64_t own[kLanes];
  double best[kEight][kLanes];
  std::uint64_t mask;  // of the bits that hold numbers
};

inline double KeyOf(double dx, double dy, std::uint64_t number, std::uint64_t mask) {
  const double distance = dx * dx + kLeastDistance + dy * dy;
  return std::bit_cast<double>((std::bit_cast<std::uint64_t>(distance) & ~mask) | number);
}

// Sorting network for eight.
inline void Sort(LanePlaces* v) {
  OrderLanes(v[0], v[2]), OrderLanes(v[1], v[3]), OrderLanes(v[4], v[6]), OrderLanes(v[5], v[7]);
  OrderLanes(v[0], v[4]), OrderLanes(v[1], v[5]), OrderLanes(v[2], v[6]), OrderLanes(v[3], v[7]);
  OrderLanes(v[0], v[1]), OrderLanes(v[2], v[3]), OrderLanes(v[4], v[5]), OrderLanes(v[6], v[7]);
  OrderLanes(v[2], v[4]), OrderLanes(v[3], v[5]);
  OrderLanes(v[1], v[4]), OrderLanes(v[3], v[6]);
  OrderLanes(v[1], v[2]), OrderLanes(v[3], v[4]), OrderLanes(v[5], v[6]);
}

// Sorts eight that fall and then rise (or the other way).
inline void SortBitonic(LanePlaces* v) {
  OrderLanes(v[0], v[4]), OrderLanes(v[1], v[5]), OrderLanes(v[2], v[6]), OrderLanes(v[3], v[7]);
  OrderLanes(v[0], v[2]), OrderLanes(v[1], v[3]), OrderLanes(v[4], v[6]), OrderLanes(v[5], v[7]);
  OrderLanes(v[0], v[1]), OrderLanes(v[2], v[3]), OrderLanes(v[4], v[5]), OrderLanes(v[6], v[7]);
}

// Puts a leaf's points among the best of each lane.
DIFFSAC_VECTOR_CLONES
void Merge(const PlaneTree::Leaf& leaf, Group* group) {
  const std::uint64_t mask = group->mask;
  LanePlaces keys[kEight];
  for (int k = 0; k < kEight; ++k) {
    const double x = leaf.x[k], y = leaf.y[k];
    const std::uint64_t number = leaf.number[k];
#pragma GCC unroll 1  // so that lanes become vectors
    for (int l = 0; l < kLanes; ++l)
      keys[k][l] =
          KeyOf(x - group->x[l], y - group->y[l], number, mask) + (number == group->own[l] ? PlaneTree::kFar : 0.0);
  }
  Sort(keys);
  // The eight least of two ascending eights.
  for (int k = 0; k < kEight; ++k)
    for (int l = 0; l < kLanes; ++l) {
      const double mine = group->best[k][l], other = keys[kEight - 1 - k][l];
      group->best[k][l] = mine < other ? mine : other;
    }
  SortBitonic(group->best);
}

// Whether a node may hold one of the best of any lane: whether the least key that a point in its box could have is
// below the lane's last.
DIFFSAC_VECTOR_CLONES
bool MayHold(const PlaneTree::Node& node, const Group& group) {
  const std::uint64_t mask = group.mask, least = node.least;
  const double low_x = node.low[0], high_x = node.high[0], low_y = node.low[1], high_y = node.high[1];
  LanePlaces keys;
  for (int l = 0; l < kLanes; ++l) {
    // To the nearest place in the box.
    const double x = group.x[l], y = group.y[l];
    const double left = x < low_x ? low_x : x, below = y < low_y ? low_y : y;
    const double near_x = left > high_x ? high_x : left, near_y = below > high_y ? high_y : below;
    keys[l] = KeyOf(near_x - x, near_y - y, least, mask);
  }
  std::uint64_t any = 0;
  for (int l = 0; l < kLanes; ++l) any += keys[l] < group.best[kEight - 1][l] ? 1 : 0;
  return any > 0;
}

// Merges the leaves below a node that may hold one of the best, those on the side of the first place first.
void SearchBelow(const PlaneTree& tree, int top, Group* group) {
  const double place[2] = {group->x[0], group->y[0]};
  int stack[64], size = 0;
  stack[size++] = top;
  while (size > 0) {
    const int index = stack[--size];
    if (!MayHold(tree.node(index), *group)) continue;
    if (tree.is_leaf(index)) {
      Merge(tree.leaf(index), group);
      continue;
    }
    const int far_side = place[tree.cut(index).axis] > tree.cut(index).place ? 0 : 1;
    stack[size++] = 2 * index + far_side;
    stack[size++] = 2 * index + 1 - far_side;
  }
}

// From the first place's leaf up: the best are known before what lies further away is asked for.
void Search(const PlaneTree& tree, int home, Group* group) {
  // These two hold at least eight.
  Merge(tree.leaf(home), group);
  Merge(tree.leaf(home ^ 1), group);
  for (int index = home / 2; index > 1; index /= 2) SearchBelow(tree, index ^ 1, group);
}

// Places in the order of the leaves that they are in, and of the parts of a leaf's box.
struct Arrangement {
  std::vector<std::int32_t> order, home;
};

Arrangement Arrange(const PlaneTree& tree, const PlanePoints& places) {
  const auto count = static_cast<int>(places.size());
  std::vector<std::int32_t> part = tree.LeavesOf(places), begin(kParts * tree.leaves() + 1, 0);
  for (int i = 0; i < count; ++i) {
    const int leaf = part[i];
    const PlaneTree::Node& box = tree.node(leaf);
    const int right = 2.0 * places.x[i] > box.low[0] + box.high[0] ? 1 : 0;
    const int above = 2.0 * places.y[i] > box.low[1] + box.high[1] ? 1 : 0;
    part[i] = kParts * (leaf - tree.leaves()) + 2 * right + (right ^ above);  // neighbouring parts follow each other
    ++begin[part[i] + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  Arrangement arranged{std::vector<std::int32_t>(count), std::vector<std::int32_t>(count)};
  for (int i = 0; i < count; ++i) {
    const std::int32_t at = begin[part[i]]++;
    arranged.order[at] = i;
    arranged.home[at] = part[i] / kParts + tree.leaves();
  }
  return arranged;
}

// Brings all coordinates to order one, so that squares stay finite; by a power of two, which rounds nothing.
void Scale(PlanePoints* points, PlanePoints* places) {
  double most = 0.0;
  for (auto* column : {&points->x, &points->y, &places->x, &places->y})
    for (double& value : *column) {
      if (!std::isfinite(value)) value = 0.0;
      most = std::max(most, std::abs(value));
    }
  constexpr int kLeastExponent = -1000;
  int exponent = 0;
  std::frexp(most, &exponent);
  const double scale = std::ldexp(1.0, -std::max(exponent, kLeastExponent));
  for (auto* column : {&points->x, &points->y, &places->x, &places->y})
    for (double& value : *column) value *= scale;
}

}  // namespace

std::vector<EightNearest> NearestEight(PlanePoints points, PlanePoints places, const std::vector<std::int32_t>& own) {
  Scale(&points, &places);
  const PlaneTree tree(points);
  const Arrangement arranged = Arrange(tree, places);
  const auto count = static_cast<int>(places.size());
  std::vector<EightNearest> nearest(count);
  Group group;
  group.mask = std::bit_ceil(points.size()) - 1;
  for (int first = 0; first < count; first += kLanes) {
    const int used = std::min(kLanes, count - first);
    for (int l = 0; l < kLanes; ++l) {
      const int place = arranged.order[first + std::min(l, used - 1)];
      group.x[l] = places.x[place], group.y[l] = places.y[place];
      group.own[l] = static_cast<std::uint64_t>(static_cast<std::int64_t>(own[place]));
    }
    std::fill_n(&group.best[0][0], kEight * kLanes, PlaneTree::kFar);
    Search(tree, arranged.home[first], &group);
    for (int l = 0; l < used; ++l)
      for (int k = 0; k < kEight; ++k)
        nearest[arranged.order[first + l]][k] =
            static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(group.best[k][l]) & group.mask);
  }
  return nearest;
}

}  // namespace diffsac
