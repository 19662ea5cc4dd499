#pragma once

#include <optional>
#include <vector>

#include "diffsac/problem/problem.h"

namespace diffsac {

/// Some of a problem's rows, in this order, as a problem of their own.
Problem PartOf(const Problem& whole, const std::vector<int>& rows);

/// How many of these rows differ (all coordinates; 0 equals −0).
int CountDistinct(const PointMatrix& rows);

/// The rows of a problem that say something. A row with a value that is not finite says nothing. Rows that are equal
/// (all coordinates; 0 equals −0) say one thing, however often it is said: keypoints of several orientations and lists
/// that were joined twice give such rows. Of these the one with the best ratio stays, else the first, in the place of
/// the first. A segment says the same with its ends swapped. Takes time linear in N.
class DeduplicatedPoints {
 public:
  /// Borrows the problem.
  explicit DeduplicatedPoints(const Problem& problem);
  /// Of these rows alone; the given problem itself where all are usable.
  const Problem& problem() const { return part_ ? *part_ : *whole_; }
  /// How many rows are not finite.
  int left_out() const { return left_out_; }
  /// How many rows say what another one says.
  int repeated() const { return repeated_; }
  /// Where a row of problem() is in the given problem.
  int RowOf(int place) const { return part_ ? rows_[static_cast<std::size_t>(place)] : place; }
  /// One value for each row of the given problem: those that are equal have the value of the one that stayed, those
  /// left out have 0. Without values there are none afterwards.
  template <class Value>
  void Spread(std::vector<Value>* values) const {
    if (!part_ || values->empty()) return;
    std::vector<Value> all;
    all.reserve(places_.size());
    for (const int place : places_) all.push_back(place < 0 ? Value{} : (*values)[static_cast<std::size_t>(place)]);
    *values = std::move(all);
  }

 private:
  const Problem* whole_;
  std::optional<Problem> part_;  ///< Where not all rows are usable; so are these two.
  std::vector<int> rows_;        ///< That stay.
  std::vector<int> places_;      ///< For each row, where it is among these; −1: left out.
  int left_out_ = 0, repeated_ = 0;
};

}  // namespace diffsac
