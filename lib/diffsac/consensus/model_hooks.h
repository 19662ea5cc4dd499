#pragma once

#include <concepts>

#include "diffsac/core/random.h"
#include "diffsac/geometry/model.h"

namespace diffsac {

/// What a model may offer the loop beyond MinimalModel. Each hook is a static member; a model without it goes without.
///
///   kResidualDof                     degrees of freedom of `Residual` for scores that need them (MAGSAC++): 1 for a
///                                    distance (assumed when absent), 2 for one image, 4 for a correspondence
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
concept HasDegeneracyRecovery = requires(const PointMatrix& points, const int* set,
                                         const typename M::Parameters& model, double threshold, Rng rng,
                                         typename M::Parameters* out, int* fits) {
  { M::RecoverFromDegeneracy(points, set, model, threshold, rng, out, fits) } -> std::same_as<int>;
};

/// Degrees of freedom of a model's residual.
template <MinimalModel Model>
constexpr int ResidualDof() {
  if constexpr (requires { Model::kResidualDof; }) return Model::kResidualDof;
  return 1;
}

}  // namespace diffsac
