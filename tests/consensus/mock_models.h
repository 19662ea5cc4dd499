#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "diffsac/consensus/sample_consensus_impl.h"
#include "diffsac/consensus/scores/mixture_impl.h"

namespace diffsac::testing {

/// A number on a line, from one point: the simplest model there is.
struct Place {
  using Parameters = Eigen::Matrix<double, 1, 1>;
  static constexpr int kDimension = 1;
  static constexpr int kMinimalSize = 1;
  static constexpr int kMaxSolutions = 1;
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    (*out)[0] = points(set[0], 0);
    return 1;
  }
  static bool Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
    const double total = weights.sum();
    if (!(total > 0.0)) return false;
    (*out)[0] = points.col(0).dot(weights) / total;
    return true;
  }
  static double Residual(const Parameters& model, const double* point) { return std::abs(model[0] - point[0]); }
};

/// From two points, with ten solutions of which the last is their mean: no solution where they are equal.
struct TenPlaces : Place {
  static constexpr int kMinimalSize = 2;
  static constexpr int kMaxSolutions = 10;
  static int SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
    const double a = points(set[0], 0), b = points(set[1], 0);
    if (a == b) return 0;
    for (int i = 0; i < 9; ++i) out[i][0] = 1e6 + i;
    out[9][0] = 0.5 * (a + b);
    return 10;
  }
};

/// Never near any point.
struct FarPlace : Place {
  static int SolveMinimal(const PointMatrix&, const int*, Parameters* out) {
    (*out)[0] = 1e9;
    return 1;
  }
};

enum class RefineMode { kToMean, kAway, kNaN, kRefuse };

/// A place with a refinement that does as it is told.
template <RefineMode kMode>
struct RefinedPlace : Place {
  static bool Refine(const PointMatrix& points, double threshold, Parameters* model) {
    if (kMode == RefineMode::kAway) (*model)[0] += 100.0 * threshold;
    if (kMode == RefineMode::kNaN) (*model)[0] = std::numeric_limits<double>::quiet_NaN();
    if (kMode != RefineMode::kToMean) return kMode != RefineMode::kRefuse;
    const Eigen::VectorXd near = ((points.col(0).array() - (*model)[0]).abs() <= threshold).template cast<double>();
    return Fit(points, near, model);
  }
};

/// A place that is degenerate when it comes from an even point: then its hook offers 5 and a bad one, for three fits.
/// What is not from a set is degenerate at 20 exactly, and mended to 30.
struct MendedPlace : Place {
  static constexpr int kMaxSolutions = 2;
  static int RecoverFromDegeneracy(const PointMatrix&, const int* set, const Parameters& model, double, Rng,
                                   Parameters* out, int* fits) {
    out[0][0] = -1e6;
    out[1][0] = set == nullptr ? 30.0 : 5.0;
    if (set == nullptr ? model[0] != 20.0 : set[0] % 2 != 0) return 0;
    *fits += 3;
    return 2;
  }
};

}  // namespace diffsac::testing
