#pragma once

#include <concepts>

#include "diffsac/core/random.h"
#include "diffsac/geometry/model.h"

namespace diffsac {

/// What a model may offer the loop beyond MinimalModel. Each hook is a static member; a model without it goes without.
///
///   kResidualDof                     degrees of freedom n that MAGSAC++ takes for `Residual`; 4 when absent, the
///   paper's
///                                    choice for correspondences, and the most accurate of 1, 2 and 4 for lines and
///                                    planes as well: the weights of n = 1 rise without bound towards 0 and waste
///                                    inliers (irls at twice the threshold, 60 % outliers, σ = ε/3: mean error of 300
///                                    lines .084°, .077° and .074° for 1, 2 and 4; planes .128°, .119° and .115°)
///   Refine(points, threshold, model) nonlinear refinement (Levenberg–Marquardt on the model's own manifold, a loss
///                                    truncated or robust at `threshold`, in the unit of `Residual`) on all points;
///                                    false when *model stays as it was
///   RecoverFromDegeneracy(points, set, model, threshold, rng, out, fits)
///                                    called for each new best model with the minimal set it was solved from: when
///                                    that set is degenerate (for a fundamental matrix: most of it on one plane),
///                                    writes up to kMaxSolutions other models to out and returns how many; 0 when
///                                    there is nothing to mend. Adds what it solved or fitted to *fits. Depends on
///                                    its arguments alone.
///   Residuals(model, columns, begin, end, out)   see scorer.h
///   Determined(points)                           see CheckPoints
///
/// The loop keeps what Refine and RecoverFromDegeneracy give only where it scores no lower.
template <class M>
concept HasRefine = requires(const PointMatrix& points, double threshold, typename M::Parameters* model) {
  { M::Refine(points, threshold, model) } -> std::same_as<bool>;
};

template <class M>
concept HasDegeneracyRecovery = requires(const PointMatrix& points, const int* set, const typename M::Parameters& model,
                                         double threshold, Rng rng, typename M::Parameters* out, int* fits) {
  { M::RecoverFromDegeneracy(points, set, model, threshold, rng, out, fits) } -> std::same_as<int>;
};

/// Degrees of freedom that MAGSAC++ takes for a model's residual.
template <MinimalModel Model>
constexpr int ResidualDof() {
  if constexpr (requires { Model::kResidualDof; }) return Model::kResidualDof;
  return 4;
}

}  // namespace diffsac
