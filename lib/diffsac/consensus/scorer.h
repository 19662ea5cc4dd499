#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "diffsac/consensus/score.h"
#include "diffsac/geometry/model.h"

namespace diffsac {

/// Scores models against one point set. The points are also kept as columns, so that residuals of a model that offers
/// `Residuals` over columns are computed several at a time; other models go point by point. Borrows `points`.
template <MinimalModel Model>
class Scorer {
 public:
  explicit Scorer(const PointMatrix& points) : points_(points), columns_(points) {
    for (int i = 0; i < Model::kDimension; ++i) pointers_[i] = columns_.col(i).data();
  }

  int size() const { return static_cast<int>(points_.rows()); }
  const PointMatrix& points() const { return points_; }

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
    constexpr double kMargin = 1e-6;
    double sum = 0.0;
    std::array<double, kBlock> residuals;
    for (int begin = 0; begin < size(); begin += kBlock) {
      if (sum + (size() - begin) + kMargin < bar) return bar;
      const int end = std::min(begin + kBlock, size());
      Residuals(model, begin, end, residuals.data());
      sum += score.Sum(residuals.data(), end - begin);
    }
    return sum;
  }

 private:
  static constexpr int kBlock = 64;
  const PointMatrix& points_;
  Eigen::MatrixXd columns_;
  std::array<const double*, Model::kDimension> pointers_;
};

}  // namespace diffsac
