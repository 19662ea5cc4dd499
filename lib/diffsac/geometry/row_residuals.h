#pragma once

#include <algorithm>

#include "diffsac/geometry/model.h"

namespace diffsac {

/// Residual of each row of `points`, into points.rows() values; several at a time for models with `Residuals` over
/// columns, bit for bit the same.
template <MinimalModel Model>
void RowResiduals(const PointMatrix& points, const typename Model::Parameters& model, double* out) {
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
}

}  // namespace diffsac
