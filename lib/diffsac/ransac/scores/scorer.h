#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "diffsac/geometry/bound_block.h"
#include "diffsac/geometry/model.h"
#include "diffsac/ransac/model_hooks.h"
#include "diffsac/ransac/scores/score.h"

namespace diffsac {

/// What scores take into account beside the points.
struct ScorePrior {
  Eigen::VectorXd weights = {};             ///< Of each point's contribution, within [0, 1]; empty: 1 each.
  std::optional<CameraPrior> cameras = {};  ///< Of models that have the hook.
  /// The cosine and sine of each point's turn, N × 2, of models that have the hook; empty: unknown.
  PointMatrix turns = {};
  double keypoint_orientation_weight = 1.0;  ///< Of points that turn otherwise, within [0, 1].

  /// For these points alone.
  ScorePrior Of(const std::vector<int>& rows) const;
};

/// Models with quick lower bounds of their squared residuals, `Bounds` (geometry/square_bounds.h).
template <class M>
concept HasSquareBounds = requires {
  typename M::Bounds;
};

/// Rows whose weights are alike within a factor of two; lighter than an eighth are one. They stand one behind the other
/// from `begin` to `end`, those before `mixed` in random order.
struct WeightClass {
  int begin, mixed, end;
  double most;  ///< No weight is larger.
};

/// Of weights within [0, 1] all rows, the heaviest class first. No weights: one class.
struct RowsByWeight {
  std::vector<int> rows;
  std::vector<WeightClass> classes;
};
RowsByWeight SortByWeight(int size, const Eigen::VectorXd& weights);

/// Scores models against one point set. The points are also kept as columns, so that residuals of a model that offers
/// `Residuals` over columns are computed several at a time; other models go point by point. Borrows `points`.
template <MinimalModel Model>
class Scorer {
 public:
  /// with_score_to_beat: whether models will be asked whether they reach a score to beat, which is prepared for.
  explicit Scorer(const PointMatrix& points, ScorePrior prior = {}, bool with_score_to_beat = true)
      : points_(points), columns_(points), prior_(std::move(prior)), rest_((size() + kBlock - 1) / kBlock + 1) {
    for (int i = 0; i < Model::kDimension; ++i) pointers_[i] = columns_.col(i).data();
    rest_.back() = 0.0;
    for (int block = static_cast<int>(rest_.size()) - 2; block >= 0; --block)
      rest_[block] = rest_[block + 1] + MostOf(block * kBlock);
    if constexpr (HasSquareBounds<Model>)
      if (with_score_to_beat) MakeBounds();
  }

  int size() const { return static_cast<int>(points_.rows()); }
  const PointMatrix& points() const { return points_; }
  const ScorePrior& prior() const { return prior_; }
  /// What is known of the points before any model; empty: 1 each.
  const Eigen::VectorXd& weights() const { return prior_.weights; }

  /// Whether points count differently.
  bool Weighs() const { return weights().size() > 0 || HasTurns(); }

  /// Of the points under a model, N values.
  Eigen::VectorXd WeightsUnder(const typename Model::Parameters& model) const {
    return WeightsUnder(model, [](int) { return true; });
  }

  void Residuals(const typename Model::Parameters& model, int begin, int end, double* out) const {
    if constexpr (requires { Model::Residuals(model, pointers_.data(), begin, end, out); }) {
      Model::Residuals(model, pointers_.data(), begin, end, out);
    } else {
      for (int i = begin; i < end; ++i) out[i - begin] = Model::Residual(model, points_.data() + i * points_.cols());
    }
  }

  Eigen::VectorXd Residuals(const typename Model::Parameters& model) const {
    Eigen::VectorXd residuals(size());
    Residuals(model, 0, size(), residuals.data());
    return residuals;
  }

  /// The model's score. Gives up, returning `score_to_beat`, once even perfect remaining points could not lift it above
  /// `score_to_beat` (the margin keeps rounding from changing what a full sum would decide), or where points drawn at
  /// random say that it is not above it (MayReach).
  double operator()(const typename Model::Parameters& model, const Score& score, double score_to_beat = -1.0) const {
    const double plausibility = Plausibility(model);
    const double score_to_beat_of_sum = score_to_beat / plausibility;
    if (!MayReach(model, score, score_to_beat_of_sum)) return score_to_beat;
    double sum = 0.0;
    std::array<double, kBlock> residuals;
    for (int begin = 0; begin < size(); begin += kBlock) {
      if (sum + rest_[begin / kBlock] + kMargin < score_to_beat_of_sum) return score_to_beat;
      const int end = std::min(begin + kBlock, size());
      Residuals(model, begin, end, residuals.data());
      sum += Sum(model, score, residuals.data(), begin, end);
    }
    return sum * plausibility;
  }

  /// The same of a model whose residuals are known.
  double operator()(const typename Model::Parameters& model, const Eigen::VectorXd& residuals, const Score& score,
                    double score_to_beat = -1.0) const {
    const double plausibility = Plausibility(model);
    return OfAll(model, score, residuals, score_to_beat / plausibility - kMargin) * plausibility;
  }

 private:
  /// What the points of the block that begins here can add at most.
  double MostOf(int begin) const {
    const int count = std::min(kBlock, size() - begin);
    return prior_.weights.size() == 0 ? count : prior_.weights.segment(begin, count).sum();
  }

  /// A run of points in the order of the bounds.
  struct Block {
    int begin, end;
    double rest;  ///< What the points from here on can add at most.
    /// Of its class: the part that is seen after it, 0 where that is no random part; what the classes behind can add;
    /// the largest weight.
    double share, after, most;
    bool last;  ///< Of its class.
  };

  /// Bounds go over the heaviest points first, so that what the rest can add falls as fast as it can.
  void MakeBounds() {
    const RowsByWeight order = SortByWeight(size(), prior_.weights);
    const Eigen::MatrixXd ordered = columns_(order.rows, Eigen::all);
    std::array<const double*, Model::kDimension> pointers;
    for (int i = 0; i < Model::kDimension; ++i) pointers[i] = ordered.col(i).data();
    bounds_.emplace(pointers.data(), size());
    if (prior_.weights.size() > 0) float_weights_ = prior_.weights(order.rows).template cast<float>();
    double rest = 0.0;
    for (auto group = order.classes.rbegin(); group != order.classes.rend(); ++group) {
      const double after = rest;
      const int blocks = (group->end - group->begin + kBoundBlock - 1) / kBoundBlock;
      for (int i = blocks - 1; i >= 0; --i) {
        const int begin = group->begin + i * kBoundBlock, end = std::min(begin + kBoundBlock, group->end);
        rest += float_weights_.size() == 0 ? end - begin
                                           : float_weights_.segment(begin, end - begin).template cast<double>().sum();
        const double seen = static_cast<double>(end - group->begin) / (group->end - group->begin);
        blocks_.push_back({begin, end, rest, end <= group->mixed ? seen : 0.0, after, group->most, i == blocks - 1});
      }
    }
    std::reverse(blocks_.begin(), blocks_.end());
  }

  /// False once a bound in single precision shows that the sum stays below `score_to_beat`, or a random part of the
  /// points of like weight has so little that this is as good as sure; models that are clearly above are not looked at
  /// to the end. Of k of n values within [0, w] that sum to `needed`, the expected sum is m = needed · k/n, and it is
  /// below m − t with a probability of at most exp(−t²/(2 w m)) (Chernoff; drawn without replacement: Hoeffding 1963,
  /// section 6). So a model that reaches the score to beat is given up once in ten million tests.
  bool MayReach([[maybe_unused]] const typename Model::Parameters& model, [[maybe_unused]] const Score& score,
                [[maybe_unused]] double score_to_beat) const {
    if constexpr (HasSquareBounds<Model>) {
      constexpr double kTwiceLog = 2.0 * 16.2, kEnoughSeen = 0.1, kClearlyAbove = 1.2;
      typename Model::Bounds::Prepared prepared;
      if (!bounds_ || !(score_to_beat > 0.0) || !score.HasUpperBound() ||
          !bounds_->Prepare(model, score.unit(), &prepared))
        return true;
      std::array<float, kBoundBlock> squares;
      double most = kMargin, before = kMargin;
      for (const Block& block : blocks_) {
        if (most + block.rest < score_to_beat) return false;
        (*bounds_)(prepared, block.begin, block.end, squares.data());
        most += score.UpperBound(squares.data(), WeightsFrom(block.begin), block.end - block.begin);
        const double expected = (score_to_beat - before - block.after) * block.share,
                     missing = expected - (most - before);
        if (missing > 0.0 && missing * missing > kTwiceLog * block.most * expected) return false;
        if (block.share > kEnoughSeen && before + (most - before) / block.share > kClearlyAbove * score_to_beat)
          return true;
        if (block.last) before = most;
      }
      return !(most < score_to_beat);
    }
    return true;
  }

  /// Of the points in the order of the bounds; null: 1 each.
  const float* WeightsFrom(int begin) const {
    return float_weights_.size() == 0 ? nullptr : float_weights_.data() + begin;
  }

  /// Those that do not `matter` may have any weight up to their own.
  template <class Matter>
  Eigen::VectorXd WeightsUnder(const typename Model::Parameters& model, const Matter& matter) const {
    Eigen::VectorXd all = weights().size() > 0 ? weights() : Eigen::VectorXd::Ones(size());
    if (HasTurns()) WeighTurns(model, 0, size(), all.data(), matter);
    return all;
  }

  bool HasTurns() const {
    return kKnowsTurns && prior_.keypoint_orientation_weight < 1.0 && prior_.turns.rows() == size();
  }

  /// Lowers the weights of those of the points [begin, end), of which weights[0] is the first, that `matter` and turn
  /// otherwise than the model says.
  template <class Matter>
  void WeighTurns([[maybe_unused]] const typename Model::Parameters& model, [[maybe_unused]] int begin,
                  [[maybe_unused]] int end, [[maybe_unused]] double* weights,
                  [[maybe_unused]] const Matter& matter) const {
    if constexpr (kKnowsTurns)
      for (int i = begin; i < end; ++i)
        if (matter(i - begin) && !Model::Turns(model, pointers_.data(), i, prior_.turns.data() + 2 * i))
          weights[i - begin] *= prior_.keypoint_orientation_weight;
  }

  /// Turns take away, so they are asked about only where the rest reaches the score to beat.
  double OfAll(const typename Model::Parameters& model, const Score& score, const Eigen::VectorXd& residuals,
               double score_to_beat) const {
    const double most = score.Sum(residuals.data(), weights().size() == 0 ? nullptr : weights().data(), size());
    if (!HasTurns() || most < score_to_beat) return most;
    const double* values = residuals.data();
    const double reach = score.unit();
    return score.Sum(values, WeightsUnder(model, [=](int i) { return values[i] < reach; }).data(), size());
  }

  double Sum(const typename Model::Parameters& model, const Score& score, const double* residuals, int begin,
             int end) const {
    const double* given = weights().size() == 0 ? nullptr : weights().data() + begin;
    if (!HasTurns()) return given ? score.Sum(residuals, given, end - begin) : score.Sum(residuals, end - begin);
    std::array<double, kBlock> own;
    for (int i = 0; i < end - begin; ++i) own[i] = given ? given[i] : 1.0;
    const double reach = score.unit();
    WeighTurns(model, begin, end, own.data(), [&](int i) { return residuals[i] < reach; });
    return score.Sum(residuals, own.data(), end - begin);
  }

  /// What the score is multiplied with, within (0, 1].
  double Plausibility([[maybe_unused]] const typename Model::Parameters& model) const {
    if constexpr (HasCameraPrior<Model>) {
      if (prior_.cameras)
        return 1.0 /
               (1.0 + prior_.cameras->strength * Model::CameraMismatch(model, prior_.cameras->K1, prior_.cameras->K2));
    }
    return 1.0;
  }

  /// What stands for the bounds of a model that has none.
  struct NoBounds {};
  template <class M>
  struct BoundsOf {
    using Type = NoBounds;
  };
  template <HasSquareBounds M>
  struct BoundsOf<M> {
    using Type = typename M::Bounds;
  };

  static constexpr bool kKnowsTurns = requires(const typename Model::Parameters& model) {
    Model::Turns(model, nullptr, 0, nullptr);
  };
  static constexpr int kBlock = 64;
  static constexpr double kMargin = 1e-6;
  const PointMatrix& points_;
  Eigen::MatrixXd columns_;
  std::array<const double*, Model::kDimension> pointers_;
  ScorePrior prior_;
  std::vector<double> rest_;       ///< What the points from a block on can add at most.
  Eigen::VectorXf float_weights_;  ///< In the order of the bounds; empty: 1 each.
  std::vector<Block> blocks_;
  std::optional<typename BoundsOf<Model>::Type> bounds_;
};

/// FitAgain with what is known of the model beside the points.
template <MinimalModel Model>
bool FitAgain(const Scorer<Model>& scorer, const Eigen::VectorXd& weights, typename Model::Parameters* model) {
  if constexpr (HasFocalPosterior<Model>)
    if (const auto& cameras = scorer.prior().cameras)
      return Model::FitFrom(scorer.points(), weights, cameras->focals(), model);
  return FitAgain<Model>(scorer.points(), weights, model);
}

}  // namespace diffsac
