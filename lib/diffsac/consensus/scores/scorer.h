#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "diffsac/consensus/model_hooks.h"
#include "diffsac/consensus/scores/score.h"
#include "diffsac/geometry/model.h"
#include "diffsac/geometry/square_bounds.h"

namespace diffsac {

/// What scores take into account beside the points.
struct ScorePrior {
  Eigen::VectorXd weights = {};             ///< Of each point's contribution, within [0, 1]; empty: 1 each.
  std::optional<CameraPrior> cameras = {};  ///< Of models that have the hook.
  /// The cosine and sine of each point's turn, N × 2, of models that have the hook; empty: unknown.
  PointMatrix turns = {};
  double turn_weight = 1.0;  ///< Of points that turn otherwise, within [0, 1].

  /// For these points alone.
  ScorePrior Of(const std::vector<int>& rows) const {
    ScorePrior some{{}, cameras, {}, turn_weight};
    if (weights.size() > 0) some.weights = weights(rows);
    if (turns.rows() > 0) some.turns = turns(rows, Eigen::all);
    return some;
  }
};

/// Models with quick lower bounds of their squared residuals, `Bounds` (geometry/square_bounds.h).
template <class M>
concept HasSquareBounds = requires {
  typename M::Bounds;
};

/// Rows by weight, within [0, 1], from the heaviest to the lightest up to 1/64; those in their order.
inline std::vector<int> HeaviestFirst(const Eigen::VectorXd& weights) {
  constexpr int kClasses = 64;
  const auto class_of = [&](Eigen::Index i) {
    return kClasses - 1 - std::clamp(static_cast<int>(weights[i] * kClasses), 0, kClasses - 1);
  };
  std::array<int, kClasses + 1> place{};
  for (Eigen::Index i = 0; i < weights.size(); ++i) ++place[class_of(i) + 1];
  for (int c = 0; c < kClasses; ++c) place[c + 1] += place[c];
  std::vector<int> rows(weights.size());
  for (Eigen::Index i = 0; i < weights.size(); ++i) rows[place[class_of(i)]++] = static_cast<int>(i);
  return rows;
}

/// Scores models against one point set. The points are also kept as columns, so that residuals of a model that offers
/// `Residuals` over columns are computed several at a time; other models go point by point. Borrows `points`.
template <MinimalModel Model>
class Scorer {
 public:
  explicit Scorer(const PointMatrix& points, ScorePrior prior = {})
      : points_(points), columns_(points), prior_(std::move(prior)), rest_((size() + kBlock - 1) / kBlock + 1) {
    for (int i = 0; i < Model::kDimension; ++i) pointers_[i] = columns_.col(i).data();
    rest_.back() = 0.0;
    for (int block = static_cast<int>(rest_.size()) - 2; block >= 0; --block)
      rest_[block] = rest_[block + 1] + MostOf(block * kBlock);
    if constexpr (HasSquareBounds<Model>) MakeBounds();
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
    Eigen::VectorXd all = weights().size() > 0 ? weights() : Eigen::VectorXd::Ones(size());
    if (HasTurns()) WeighTurns(model, 0, size(), all.data(), [](int) { return true; });
    return all;
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

  /// The model's score. Gives up, returning `bar`, once even perfect remaining points could not lift it above `bar`;
  /// the margin keeps rounding from changing what a full sum would decide.
  double operator()(const typename Model::Parameters& model, const Score& score, double bar = -1.0) const {
    const double plausibility = Plausibility(model);
    const double bar_of_sum = bar / plausibility;
    if (!MayReach(model, score, bar_of_sum)) return bar;
    if (!score.IsSum()) return OfAll(model, score, Residuals(model), bar_of_sum - kMargin) * plausibility;
    double sum = 0.0;
    std::array<double, kBlock> residuals;
    for (int begin = 0; begin < size(); begin += kBlock) {
      if (sum + rest_[begin / kBlock] + kMargin < bar_of_sum) return bar;
      const int end = std::min(begin + kBlock, size());
      Residuals(model, begin, end, residuals.data());
      sum += Sum(model, score, residuals.data(), begin, end);
    }
    return sum * plausibility;
  }

  /// The same of a model whose residuals are known; of a score that is a sum whatever the bar is.
  double operator()(const typename Model::Parameters& model, const Eigen::VectorXd& residuals, const Score& score,
                    double bar = -1.0) const {
    const double plausibility = Plausibility(model);
    return OfAll(model, score, residuals, bar / plausibility - kMargin) * plausibility;
  }

 private:
  /// What the points of the block that begins here can add at most.
  double MostOf(int begin) const {
    const int count = std::min(kBlock, size() - begin);
    return prior_.weights.size() == 0 ? count : prior_.weights.segment(begin, count).sum();
  }

  /// Bounds go over the heaviest points first, so that what the rest can add falls as fast as it can.
  void MakeBounds() {
    std::array<const double*, Model::kDimension> pointers = pointers_;
    Eigen::MatrixXd ordered;
    if (prior_.weights.size() > 0) {
      const std::vector<int> rows = HeaviestFirst(prior_.weights);
      ordered = columns_(rows, Eigen::all);
      float_weights_ = prior_.weights(rows).template cast<float>();
      for (int i = 0; i < Model::kDimension; ++i) pointers[i] = ordered.col(i).data();
    }
    bounds_.emplace(pointers.data(), size());
    bound_rest_.assign((size() + kBoundBlock - 1) / kBoundBlock + 1, 0.0);
    for (int block = static_cast<int>(bound_rest_.size()) - 2; block >= 0; --block) {
      const int begin = block * kBoundBlock, count = std::min(kBoundBlock, size() - begin);
      const double most =
          float_weights_.size() == 0 ? count : float_weights_.segment(begin, count).template cast<double>().sum();
      bound_rest_[block] = bound_rest_[block + 1] + most;
    }
  }

  /// False once a bound in single precision shows that the sum stays below `bar`.
  bool MayReach([[maybe_unused]] const typename Model::Parameters& model, [[maybe_unused]] const Score& score,
                [[maybe_unused]] double bar) const {
    if constexpr (HasSquareBounds<Model>) {
      static_assert(kBoundBlock % kBlock == 0);
      typename Model::Bounds::Prepared prepared;
      if (!(bar > 0.0) || !score.HasBound() || !bounds_->Prepare(model, score.unit(), &prepared)) return true;
      if (!score.IsSum()) return !(BoundOfAll(prepared, score) + kMargin < bar);
      const float* weights = float_weights_.size() == 0 ? nullptr : float_weights_.data();
      std::array<float, kBoundBlock> squares;
      double most = kMargin;
      for (int begin = 0; begin < size(); begin += kBoundBlock) {
        if (most + bound_rest_[begin / kBoundBlock] < bar) return false;
        const int end = std::min(begin + kBoundBlock, size());
        (*bounds_)(prepared, begin, end, squares.data());
        most += score.Bound(squares.data(), weights == nullptr ? nullptr : weights + begin, end - begin);
      }
      return !(most < bar);
    }
    return true;
  }

  /// prepared: a model, as the bounds take it.
  template <class Prepared>
  double BoundOfAll(const Prepared& prepared, const Score& score) const {
    SquareHistogram histogram;
    std::array<float, kBoundBlock> squares;
    for (int begin = 0; begin < size(); begin += kBoundBlock) {
      const int end = std::min(begin + kBoundBlock, size());
      (*bounds_)(prepared, begin, end, squares.data());
      histogram.Add(squares.data(), float_weights_.size() == 0 ? nullptr : float_weights_.data() + begin, end - begin);
    }
    return score.BoundOfAll(histogram);
  }

  bool HasTurns() const { return kKnowsTurns && prior_.turn_weight < 1.0 && prior_.turns.rows() == size(); }

  /// Lowers the weights of those of the points [begin, end), of which weights[0] is the first, that `matter` and turn
  /// otherwise than the model says.
  template <class Matter>
  void WeighTurns([[maybe_unused]] const typename Model::Parameters& model, [[maybe_unused]] int begin,
                  [[maybe_unused]] int end, [[maybe_unused]] double* weights,
                  [[maybe_unused]] const Matter& matter) const {
    if constexpr (kKnowsTurns)
      for (int i = begin; i < end; ++i)
        if (matter(i - begin) && !Model::Turns(model, pointers_.data(), i, prior_.turns.data() + 2 * i))
          weights[i - begin] *= prior_.turn_weight;
  }

  double OfAll(const typename Model::Parameters& model, const Score& score, const Eigen::VectorXd& residuals,
               double bar) const {
    if (HasTurns()) return score.OfAll(residuals.data(), WeightsUnder(model).data(), size(), bar);
    return score.OfAll(residuals.data(), weights().size() == 0 ? nullptr : weights().data(), size(), bar);
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
  std::vector<double> rest_;        ///< What the points from a block on can add at most.
  Eigen::VectorXf float_weights_;   ///< In the order of the bounds; empty: 1 each.
  std::vector<double> bound_rest_;  ///< The same as rest_ of the bounds' blocks, in their order.
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
