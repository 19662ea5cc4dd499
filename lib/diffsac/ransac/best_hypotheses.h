#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "diffsac/geometry/model.h"

namespace diffsac {

template <MinimalModel Model>
class Scorer;

/// The best K hypotheses seen so far that differ in their inliers, best first; the earlier one first where scores tie.
/// Two differ where less than `alike` of the inliers of either are inliers of both.
template <MinimalModel Model, class ScorerType = Scorer<Model>>
class BestHypotheses {
 public:
  struct Entry {
    typename Model::Parameters model;
    double score;
    std::vector<std::uint8_t> inliers;  ///< At `threshold`; empty when only one hypothesis is kept.
  };

  /// least: share of the best's score that another must have. Borrows the scorer, whose `Residuals` of a model is all
  /// that is asked.
  BestHypotheses(const ScorerType& scorer, double threshold, int capacity, double alike = 1.0, double least = 0.0)
      : scorer_(scorer),
        threshold_(threshold),
        capacity_(capacity),
        alike_(alike),
        least_(least),
        score_to_beat_(capacity > 0 ? -1.0 : std::numeric_limits<double>::infinity()) {}

  /// A score must be above this to enter. It never falls, not even where one hypothesis takes the place of several:
  /// draws that were scored against an older score to beat (HypothesisBlock) may have been given up.
  double score_to_beat() const {
    return entries_.empty() || least_ == 0.0 ? score_to_beat_ : std::max(score_to_beat_, least_ * best());
  }
  /// A score must be above this to become the best.
  double best() const { return entries_.empty() ? -1.0 : entries_.front().score; }
  const std::vector<Entry>& entries() const { return entries_; }

  void Offer(const typename Model::Parameters& model, double score) {
    std::vector<std::uint8_t> inliers;
    Offer(model, score, &inliers);
  }
  /// inliers: of the model at `threshold`, worked out where that is empty and asked for.
  void Offer(const typename Model::Parameters& model, double score, std::vector<std::uint8_t>* inliers) {
    if (!(score > score_to_beat())) return;
    Entry entry{model, score, {}};
    if (capacity_ > 1) {
      if (inliers->empty()) *inliers = Inliers(model);
      entry.inliers = *inliers;
      const auto twin = [&](const Entry& other) { return Alike(other.inliers, entry.inliers); };
      const auto worse =
          std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return score > e.score; });
      if (std::any_of(entries_.begin(), worse, twin)) return;
      entries_.erase(std::remove_if(worse, entries_.end(), twin), entries_.end());
    }
    const auto place =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& other) { return score > other.score; });
    entries_.insert(place, std::move(entry));
    if (static_cast<int>(entries_.size()) > capacity_) entries_.pop_back();
    if (static_cast<int>(entries_.size()) == capacity_)
      score_to_beat_ = std::max(score_to_beat_, entries_.back().score);
  }

 private:
  std::vector<std::uint8_t> Inliers(const typename Model::Parameters& model) const {
    const Eigen::VectorXd residuals = scorer_.Residuals(model);
    std::vector<std::uint8_t> inliers(residuals.size());
    for (Eigen::Index i = 0; i < residuals.size(); ++i) inliers[i] = residuals[i] <= threshold_;
    return inliers;
  }

  bool Alike(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) const {
    if (alike_ == 1.0) return a == b;
    int both = 0, either = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      both += a[i] & b[i];
      either += a[i] | b[i];
    }
    return both >= alike_ * either;
  }

  const ScorerType& scorer_;
  double threshold_;
  int capacity_;
  double alike_;
  double least_;
  double score_to_beat_;
  std::vector<Entry> entries_;
};

}  // namespace diffsac
