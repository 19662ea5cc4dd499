#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace diffsac {

/// Keeps the K distinct index sets of smallest cost; equal costs are ordered by their indices, so the result does not
/// depend on the order of the calls (a set must always come with the same cost and ascending members).
template <int Size>
class BestSets {
 public:
  struct Entry {
    double cost = 0.0;
    std::array<int, Size> set{};
    bool operator<(const Entry& other) const { return cost != other.cost ? cost < other.cost : set < other.set; }
  };

  explicit BestSets(int capacity) : capacity_(capacity > 0 ? static_cast<std::size_t>(capacity) : 0) {}

  void Offer(double cost, const std::array<int, Size>& set) {
    if (full() && !(cost <= worst_)) return;
    Insert({cost, set});
  }

  /// A cost above this is not kept; infinite while there is room.
  double bound() const { return full() ? worst_ : std::numeric_limits<double>::infinity(); }

  /// Best first.
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  bool full() const { return entries_.size() >= capacity_; }

  void Insert(const Entry& entry) {
    if (capacity_ == 0) return;
    std::size_t at = entries_.size();
    while (at > 0 && entry < entries_[at - 1]) --at;
    if (at > 0 && entries_[at - 1].set == entry.set) return;
    entries_.insert(entries_.begin() + at, entry);
    if (entries_.size() > capacity_) entries_.pop_back();
    worst_ = entries_.back().cost;
  }

  std::size_t capacity_;
  double worst_ = 0.0;
  std::vector<Entry> entries_;
};

}  // namespace diffsac
