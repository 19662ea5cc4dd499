#pragma once

#include <Eigen/Core>

namespace diffsac {

/// N points, one a row, row-major so that a point is contiguous.
using PointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Model parameters behind type erasure. Line (a, b, c): a x + b y + c = 0, a² + b² = 1. Plane (a, b, c, d) likewise.
using ModelParameters = Eigen::VectorXd;

}  // namespace diffsac
