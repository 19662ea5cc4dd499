#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "diffsac/consensus/sample_consensus.h"

namespace diffsac {

/// The best K hypotheses seen so far that differ in their inliers, best first; the earlier one first where scores tie.
template <MinimalModel Model>
class BestHypotheses {
 public:
  struct Entry {
    typename Model::Parameters model;
    double score;
    std::vector<std::uint8_t> inliers;  ///< At `threshold`; empty when only one hypothesis is kept.
  };

  BestHypotheses(const PointMatrix& points, double threshold, int capacity)
      : points_(points), threshold_(threshold), capacity_(capacity) {}

  /// A score must be above this to enter.
  double bar() const { return static_cast<int>(entries_.size()) < capacity_ ? -1.0 : entries_.back().score; }
  /// A score must be above this to become the best.
  double best() const { return entries_.empty() ? -1.0 : entries_.front().score; }
  const std::vector<Entry>& entries() const { return entries_; }

  void Offer(const typename Model::Parameters& model, double score) {
    if (!(score > bar())) return;
    Entry entry{model, score, {}};
    if (capacity_ > 1) {
      entry.inliers = InlierMask<Model>(points_, model, threshold_);
      const auto twin = std::find_if(entries_.begin(), entries_.end(),
                                     [&](const Entry& other) { return other.inliers == entry.inliers; });
      if (twin != entries_.end()) {
        if (!(score > twin->score)) return;
        entries_.erase(twin);
      }
    }
    const auto place =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& other) { return score > other.score; });
    entries_.insert(place, std::move(entry));
    if (static_cast<int>(entries_.size()) > capacity_) entries_.pop_back();
  }

 private:
  const PointMatrix& points_;
  double threshold_;
  int capacity_;
  std::vector<Entry> entries_;
};

}  // namespace diffsac
