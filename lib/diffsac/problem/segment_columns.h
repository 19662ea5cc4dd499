#pragma once

#include <Eigen/Core>
#include <cmath>

#include "diffsac/geometry/points.h"

namespace diffsac {

/// Segments as what residuals of many vanishing points are made of, in single precision.
struct SegmentColumns {
  Eigen::ArrayXf a, b, c;  ///< The line a x + b y + c = 0, a² + b² = 1.
  Eigen::ArrayXf x, y;     ///< The middle.
  Eigen::ArrayXf length;

  SegmentColumns(const PointMatrix& points, const Eigen::VectorXd& lengths) : length(lengths.cast<float>()) {
    const Eigen::Index count = points.rows();
    for (Eigen::ArrayXf* column : {&a, &b, &c, &x, &y}) column->resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Vector2d first = points.row(i).head<2>(), second = points.row(i).tail<2>();
      const Eigen::Vector2d along = second - first, middle = 0.5 * (first + second);
      const double size = along.norm();
      const Eigen::Vector2d normal =
          size > 0.0 ? Eigen::Vector2d(-along[1] / size, along[0] / size) : Eigen::Vector2d::Zero();
      a[i] = static_cast<float>(normal[0]);
      b[i] = static_cast<float>(normal[1]);
      c[i] = static_cast<float>(-normal.dot(middle));
      x[i] = static_cast<float>(middle[0]);
      y[i] = static_cast<float>(middle[1]);
      // What has no direction supports nothing.
      if (!(size > 0.0)) length[i] = 0.0f;
    }
  }

  Eigen::Index count() const { return length.size(); }
  /// Squared sines, as VanishingPoint::Residual.
  Eigen::ArrayXf Squares(const Eigen::Vector3f& v) const {
    const Eigen::ArrayXf wx = v[0] - v[2] * x, wy = v[1] - v[2] * y;
    return ((a * v[0] + b * v[1] + c * v[2]).square() / (wx.square() + wy.square() + 1e-18f)).min(1.0f);
  }
};

}  // namespace diffsac
