#include "diffsac/geometry/calibration.h"

#include <cmath>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

/// Entries of a matrix that was computed that are not quite 0 are, relative to the one that they stand beside.
constexpr double kRounding = 1e-9;

/// Of a matrix that is finite and no calibration, why not.
std::string ProblemOf(const Eigen::Matrix3d& K) {
  const auto has_zeros = [&](int row0, int column0, int row1, int column1) {
    return K(row0, column0) == 0.0 && K(row1, column1) == 0.0;
  };
  if (!has_zeros(2, 0, 2, 1) && has_zeros(0, 2, 1, 2)) return "its last column is 0 0 1: it is transposed";
  if (!has_zeros(2, 0, 2, 1) || !(K(2, 2) > 0.0)) return "its last row is not 0 0 1, nor a multiple above 0";
  if (K(0, 0) > 0.0 && K(1, 1) < 0.0)
    return "its fy is below 0: where y points up, give height - y for y, height - cy for cy, and fy above 0";
  if (!(K(0, 0) > 0.0 && K(1, 1) > 0.0)) return "its focal lengths are not above 0";
  return "its second row does not begin with 0";
}

}  // namespace

Eigen::Matrix3d CheckedCalibration(const Eigen::Matrix3d& K, const std::string& what) {
  const std::string expected = what + ": expected a calibration matrix (fx s cx, 0 fy cy, 0 0 1), but ";
  if (!K.allFinite()) throw Error(expected + "a value of it is not finite");
  // Exactly what was given, where nothing has to be done.
  if (IsCalibration(K)) return K;
  Eigen::Matrix3d rounded = K;
  for (int i = 0; i < 2; ++i)
    if (std::abs(K(2, i)) <= kRounding * std::abs(K(2, 2))) rounded(2, i) = 0.0;
  if (std::abs(K(1, 0)) <= kRounding * std::abs(K(1, 1))) rounded(1, 0) = 0.0;
  const Eigen::Matrix3d scaled = rounded / rounded(2, 2);
  if (!(rounded(2, 2) > 0.0) || !IsCalibration(scaled)) throw Error(expected + ProblemOf(rounded));
  return scaled;
}

}  // namespace diffsac
