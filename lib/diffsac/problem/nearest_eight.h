#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace diffsac {

/// Places in a plane, a coordinate a column.
struct PlanePoints {
  explicit PlanePoints(std::size_t count = 0) : x(count), y(count) {}
  std::size_t size() const { return x.size(); }
  std::vector<double> x, y;
};

inline constexpr int kEight = 8;
/// Numbers of points.
using EightNearest = std::array<std::int32_t, kEight>;

/// The eight points nearest to each place, nearest first, of equally near ones the lower number first (distances
/// squared that agree to about 2⁻⁵² times the number of points count as equal). `own`: the number of the point that a
/// place is itself, which is passed over, or -1. At least 9 points. Exact wherever the points lie; a value that is not
/// finite counts as 0.
///
/// A balanced k-d tree of the points; places are looked up in groups that lie near each other, each in a lane of a
/// vector, so that one pass over a leaf serves all of them. The time a place grows with log of the points alone, and
/// does not depend on how they cluster or coincide.
std::vector<EightNearest> NearestEight(PlanePoints points, PlanePoints places, const std::vector<std::int32_t>& own);

}  // namespace diffsac
