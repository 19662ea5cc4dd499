#include "diffsac/problem/deduplicated_points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// Equal rows have the same.
std::uint64_t HashOf(const double* row, Eigen::Index columns) {
  std::uint64_t hash = 0;
  for (Eigen::Index c = 0; c < columns; ++c) {
    // Adding 0 makes 0 of −0. The multiplier is 2⁶⁴ over the golden ratio (Knuth's multiplicative hash).
    hash = (hash ^ std::bit_cast<std::uint64_t>(row[c] + 0.0)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return hash;
}

bool IsFinite(const double* row, Eigen::Index columns) {
  return std::all_of(row, row + columns, [](double value) { return std::isfinite(value); });
}

/// Numbers the rows that differ, in their order: a table with open addressing, at most half full. A slot has the hash's
/// other half as well, so that rows that differ are hardly ever looked at.
class DistinctRows {
 public:
  explicit DistinctRows(const PointMatrix& points)
      : points_(points), table_(std::bit_ceil(2 * static_cast<std::size_t>(points.rows()) + 1)) {}

  /// Asks memory for what NumberOf looks at first.
  void Fetch(Eigen::Index row) const {
    __builtin_prefetch(&table_[HashOf(points_.row(row).data(), points_.cols()) & (table_.size() - 1)], 1);
  }

  /// The number of the rows that equal this one; the next number for the first of them.
  int NumberOf(Eigen::Index row) {
    const double* values = points_.row(row).data();
    const Eigen::Index columns = points_.cols();
    const std::uint64_t hash = HashOf(values, columns);
    const auto tag = static_cast<std::uint32_t>(hash >> 32);
    for (std::size_t place = hash;; ++place) {
      Slot& slot = table_[place & (table_.size() - 1)];
      if (slot.number < 0) {
        slot = {tag, static_cast<int>(firsts_.size())};
        firsts_.push_back(row);
        return slot.number;
      }
      if (slot.tag == tag &&
          std::equal(values, values + columns, points_.row(firsts_[static_cast<std::size_t>(slot.number)]).data()))
        return slot.number;
    }
  }

 private:
  struct Slot {
    std::uint32_t tag = 0;
    int number = -1;
  };
  const PointMatrix& points_;
  std::vector<Slot> table_;
  std::vector<Eigen::Index> firsts_;
};

/// Segments from the end that is farther left, else higher up.
PointMatrix Ordered(const PointMatrix& segments) {
  PointMatrix ordered = segments;
  for (Eigen::Index i = 0; i < segments.rows(); ++i)
    if (segments(i, 2) < segments(i, 0) || (segments(i, 2) == segments(i, 0) && segments(i, 3) < segments(i, 1)))
      ordered.row(i) << segments.row(i).tail<2>(), segments.row(i).head<2>();
  return ordered;
}

}  // namespace

int CountDistinct(const PointMatrix& rows) {
  DistinctRows distinct(rows);
  int count = 0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) count = std::max(count, distinct.NumberOf(i) + 1);
  return count;
}

Problem PartOf(const Problem& whole, const std::vector<int>& rows) {
  const Eigen::Index count = whole.points.rows();
  Problem part;
  part.task = whole.task;
  part.inlier_threshold = whole.inlier_threshold;
  part.threshold_is_default = whole.threshold_is_default;
  part.cameras = whole.cameras;
  part.camera_prior1 = whole.camera_prior1;
  part.camera_prior2 = whole.camera_prior2;
  part.size1 = whole.size1;
  part.size2 = whole.size2;
  part.initial_model = whole.initial_model;
  part.points = whole.points(rows, Eigen::all);
  if (whole.snn_ratio.size() == count) part.snn_ratio = whole.snn_ratio(rows);
  part.scored = whole.scored;
  if (whole.scale_rotation_changes.rows() == count)
    part.scale_rotation_changes = whole.scale_rotation_changes(rows, Eigen::all);
  if (whole.descriptors.rows() == count) part.descriptors = whole.descriptors(rows, Eigen::all);
  return part;
}

DeduplicatedPoints::DeduplicatedPoints(const Problem& problem) : whole_(&problem) {
  const PointMatrix& points = problem.points;
  const bool has_ratio = problem.snn_ratio.size() == points.rows();
  const bool segments = problem.task == Task::kVanishingPoint && points.cols() == 4;
  const PointMatrix ordered = segments ? Ordered(points) : PointMatrix();
  DistinctRows distinct(segments ? ordered : points);
  rows_.reserve(static_cast<std::size_t>(points.rows()));
  places_.reserve(static_cast<std::size_t>(points.rows()));
  constexpr Eigen::Index kAhead = 16;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (i + kAhead < points.rows()) distinct.Fetch(i + kAhead);
    const int next = static_cast<int>(rows_.size());
    const int place = IsFinite(points.row(i).data(), points.cols()) ? distinct.NumberOf(i) : -1;
    places_.push_back(place);
    left_out_ += place < 0;
    if (place == next) {
      rows_.push_back(static_cast<int>(i));
    } else if (place >= 0) {
      ++repeated_;
      int& best = rows_[static_cast<std::size_t>(place)];
      if (has_ratio && problem.snn_ratio[i] < problem.snn_ratio[best]) best = static_cast<int>(i);
    }
  }
  if (left_out_ + repeated_ > 0) part_ = PartOf(problem, rows_);
}

}  // namespace diffsac
