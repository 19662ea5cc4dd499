#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <concepts>

#include "diffsac/geometry/points.h"

namespace diffsac {

/// What the sample-consensus loop, the scores and the refits ask of a model. A model is stateless: static functions
/// over a fixed-size parameter vector, so that the hot loop has no calls to look up.
///
///   Parameters                      fixed-size Eigen column vector of doubles
///   kDimension                      values in a point (columns of the PointMatrix)
///   kMinimalSize                    γ, points in a minimal set
///   kMaxSolutions                   models that one minimal set can have at most
///   SolveMinimal(points, set, out)  solves the γ rows `set[0..γ)`; writes up to kMaxSolutions models and
///                                   returns how many: 0 when the set is degenerate
///   Fit(points, weights, out)       weighted non-minimal fit (weights >= 0, N values); false when the points with
///                                   positive weight determine no model
///   Residual(model, point)          unsigned distance, linear, in the data's unit; `point` has kDimension values
template <class M>
concept MinimalModel = requires(const PointMatrix& points, const int* set, typename M::Parameters* out,
                                const Eigen::VectorXd& weights, const typename M::Parameters& model,
                                const double* point) {
  { M::kDimension } -> std::convertible_to<int>;
  { M::kMinimalSize } -> std::convertible_to<int>;
  { M::kMaxSolutions } -> std::convertible_to<int>;
  { M::SolveMinimal(points, set, out) } -> std::same_as<int>;
  { M::Fit(points, weights, out) } -> std::same_as<bool>;
  { M::Residual(model, point) } -> std::same_as<double>;
};

/// Residual of each row of `points`; several at a time for models with `Residuals` over columns, bit for bit the same.
template <MinimalModel Model>
Eigen::VectorXd RowResiduals(const PointMatrix& points, const typename Model::Parameters& model) {
  Eigen::VectorXd residuals(points.rows());
  double* out = residuals.data();
  const int size = static_cast<int>(points.rows());
  constexpr int kDimension = Model::kDimension;
  const auto row = [&](int i) { return points.data() + static_cast<Eigen::Index>(i) * kDimension; };
  if constexpr (requires(const double* const* columns) { Model::Residuals(model, columns, 0, 0, out); }) {
    constexpr int kBlock = 64;
    double columns[kDimension][kBlock];
    const double* pointers[kDimension];
    for (int j = 0; j < kDimension; ++j) pointers[j] = columns[j];
    for (int begin = 0; begin < size; begin += kBlock) {
      const int count = std::min(kBlock, size - begin);
      for (int i = 0; i < count; ++i)
        for (int j = 0; j < kDimension; ++j) columns[j][i] = row(begin + i)[j];
      Model::Residuals(model, pointers, 0, count, out + begin);
    }
  } else {
    for (int i = 0; i < size; ++i) out[i] = Model::Residual(model, row(i));
  }
  return residuals;
}

}  // namespace diffsac
