#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "diffsac/core/parallel.h"
#include "diffsac/geometry/model.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"
#include "diffsac/ransac/solve_set.h"

namespace diffsac {

/// A block of minimal sets, and what comes of each before earlier draws matter: the models that it is solved to, and
/// what they score. Several threads solve and score all that is left of a block at once; one does each draw when it is
/// asked for. Either way the draws come in their order and are the same.
template <MinimalModel Model, class Scorer>
class HypothesisBlock {
 public:
  /// What comes of one minimal set.
  struct Draw {
    const int* set = nullptr;  ///< γ indices.
    int solutions = 0;
    typename Model::Parameters models[Model::kMaxSolutions];
    double scores[Model::kMaxSolutions];
  };

  /// capacity: sets at a time, 0: from 64 growing to 4096. threads: 0 for all cores. Borrows the rest.
  HypothesisBlock(const PointMatrix& points, const Scorer& scorer, int capacity, int threads)
      : points_(points),
        scorer_(scorer),
        grows_(capacity <= 0),
        capacity_(grows_ ? kFirstCapacity : capacity),
        threads_(threads <= 0 ? HardwareThreads() : threads) {}

  /// Draws sets in place of the last ones, as many as there is room for and `most` at most; false when the sampler had
  /// fewer.
  bool Fill(MinimalSampler& sampler, std::int64_t most) {
    const std::int64_t count = std::min<std::int64_t>(capacity_, most);
    if (grows_) capacity_ = std::min(2 * capacity_, kLastCapacity);
    sets_ = DrawSets(sampler, Model::kMinimalSize, count);
    size_ = static_cast<int>(sets_.size()) / Model::kMinimalSize;
    if (static_cast<int>(draws_.size()) < size_) draws_.resize(size_);
    next_ = scored_ = 0;
    if (threads_ > 1) ParallelFor(size_, threads_, [&](std::int64_t i) { Solve(static_cast<int>(i)); });
    return size_ == count;
  }

  /// The next draw, null after the last one. score_to_beat: what its score must exceed to matter; draws that were
  /// scored against an older, lower score to beat need not be scored again.
  const Draw* Next(double score_to_beat) {
    if (next_ == size_) return nullptr;
    if (threads_ <= 1) {
      Solve(next_);
      ScoreOne(next_, score_to_beat);
    } else if (next_ == scored_) {
      ParallelFor(size_ - next_, threads_,
                  [&](std::int64_t i) { ScoreOne(next_ + static_cast<int>(i), score_to_beat); });
      scored_ = size_;
    }
    return &draws_[next_++];
  }

 private:
  void Solve(int i) {
    draws_[i].set = sets_.data() + static_cast<std::size_t>(i) * Model::kMinimalSize;
    draws_[i].solutions = SolveSet<Model>(points_, draws_[i].set, draws_[i].models);
  }

  void ScoreOne(int i, double score_to_beat) {
    Draw& draw = draws_[i];
    for (int k = 0; k < draw.solutions; ++k) draw.scores[k] = scorer_(draw.models[k], score_to_beat);
  }

  static constexpr int kFirstCapacity = 64;
  static constexpr int kLastCapacity = 4096;

  const PointMatrix& points_;
  const Scorer& scorer_;
  bool grows_;
  int capacity_;
  int threads_;
  std::vector<int> sets_;
  std::vector<Draw> draws_;
  int size_ = 0;
  int next_ = 0;
  int scored_ = 0;  ///< Draws before this one are scored. With several threads alone.
};

}  // namespace diffsac
