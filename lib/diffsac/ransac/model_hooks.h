#pragma once

#include <array>
#include <concepts>
#include <cstdint>

#include "diffsac/core/random.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/focal.h"
#include "diffsac/geometry/model.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/ransac/solve_set.h"

namespace diffsac {

// What a model may offer the loop beyond MinimalModel, as static members. A model without a hook goes without.
//
//   kResidualDof                     degrees of freedom n that MAGSAC++ takes for `Residual`. 4 when absent: the
//                                    choice of its authors for correspondences, and the most accurate of 1, 2 and 4
//                                    for lines and planes as well. The weights of n = 1 rise without bound towards 0
//                                    and waste inliers (irls at twice the threshold, 60 % outliers, σ = ε/3: mean
//                                    error of 300 lines .084°, .077° and .074° for 1, 2 and 4; planes .128°, .119°
//                                    and .115°). Sampson distances have 1 (docs/experiments.md): F .441/.561,
//                                    .425/.543 and .417/.511 for 1, 2 and 4, E no difference
//   Refine(points, weights, loss, model, steps)
//                                    nonlinear refinement (Levenberg–Marquardt on the model's own manifold, so many
//                                    steps at most) with a weight ≥ 0 for each point and a loss in the unit of
//                                    `Residual`; false when *model stays as it was
//   Refine(points, threshold, model) the same with a loss truncated at `threshold` and all points alike, of a model
//                                    that has no other
//   FitFrom(points, weights, model)  the non-minimal fit of a model whose `Fit` is a poor one without a start (for an
//                                    essential matrix, which eight linear equations fit badly): from *model; false
//                                    when it stays as it was
//   RecoverFromDegeneracy(points, set, model, threshold, rng, out, fits)
//                                    called for each new best model with the minimal set it was solved from, and with
//                                    a null set for what local optimisation made of it: where that is degenerate (for
//                                    a fundamental matrix: most of its points on one plane), writes up to
//                                    kMaxSolutions other models to out and returns how many; 0 when there is nothing
//                                    to mend. Adds what it solved or fitted to *fits. Depends on its arguments alone.
//   CameraMismatch(model, K1, K2)    how badly the model fits cameras of these calibrations, at least 0: scores are
//                                    divided by 1 + strength · that, where a CameraPrior is given (for a fundamental
//                                    matrix: (s₁ − s₂)/s₂ of the essential matrix that it makes with them; for a
//                                    homography: (s₁ − s₃)/s₂ of the motion)
//   Marginalise(points, weights, loss, priors, model, out)
//                                    for a model with unknown focal lengths: their posterior under the priors, and the
//                                    model at the posterior's median, asked for once at the end where priors are given
//   OtherMinimum(points, threshold, model, other, fits)
//                                    for a model of two minima (an absolute pose of points on a plane): makes *model
//                                    the better of them, and returns whether *other, the worse, is as good within what
//                                    noise allows; the loss is truncated at `threshold`. Adds its fits to *fits
//   kHasRivals                       true for a model that may have a rival: another one that explains other points
//                                    equally well (a symmetric body's). Hypotheses of the same points then count as one
//   kFreedom                         of how many free parameters the model is, where that is not kResidualDimension · γ
//   Residuals(model, columns, begin, end, out)   several at a time, from columns (scorer.h)
//   Turns(model, columns, i, turn)   whether the keypoint of point i turned as the model says, for
//   options.keypoint_orientation_weight kUsualPolicies                   true: nothing is compiled but local
//   optimisation by inner samples and iterated
//                                    refits, which is all that search.h asks for
//   kFits                            false: `Fit` makes nothing of any points, and nothing that fits is compiled
//   Determined(points)               whether all points together determine a model (CheckPoints)
//
// The loop keeps what Refine and RecoverFromDegeneracy give only where it scores no lower.

template <class M>
concept HasUsualPolicies = requires {
  requires M::kUsualPolicies;
};

template <class M>
concept NeverFits = requires {
  requires !M::kFits;
};

template <class M>
concept HasRobustRefine = requires(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                                   typename M::Parameters* model, int steps) {
  { M::Refine(points, weights, loss, model, steps) } -> std::same_as<bool>;
};

template <class M>
concept HasRefine = HasRobustRefine<M> ||
    requires(const PointMatrix& points, double threshold, typename M::Parameters* model) {
  { M::Refine(points, threshold, model) } -> std::same_as<bool>;
};

template <class M>
concept HasFitFrom = requires(const PointMatrix& points, const Eigen::VectorXd& weights,
                              typename M::Parameters* model) {
  { M::FitFrom(points, weights, model) } -> std::same_as<bool>;
};

/// Weighted least squares by points that a model, *model, has found: its `FitFrom`, or its `Fit`. False, leaving
/// *model, when they determine none.
template <MinimalModel Model>
bool FitAgain(const PointMatrix& points, const Eigen::VectorXd& weights, typename Model::Parameters* model) {
  if constexpr (HasFitFrom<Model>) {
    return Model::FitFrom(points, weights, model);
  } else {
    typename Model::Parameters fitted;
    if (!Model::Fit(points, weights, &fitted)) return false;
    *model = fitted;
    return true;
  }
}

/// Calibrations that the two images may have, and how much a score says of them.
struct CameraPrior {
  Eigen::Matrix3d K1, K2;
  double strength = 0.0;
  /// Of a model with unknown focal lengths: how surely they are those of K1 and K2. 0: unknown.
  std::array<double, 2> focal_log_sigma = {};
  FocalPriors focals() const { return {{{K1(0, 0), focal_log_sigma[0]}, {K2(0, 0), focal_log_sigma[1]}}}; }
};

template <class M>
concept HasCameraPrior = requires(const typename M::Parameters& model, const Eigen::Matrix3d& camera) {
  { M::CameraMismatch(model, camera, camera) } -> std::same_as<double>;
};

template <class M>
concept HasDegeneracyRecovery = requires(const PointMatrix& points, const int* set, const typename M::Parameters& model,
                                         double threshold, Rng rng, typename M::Parameters* out, int* fits) {
  { M::RecoverFromDegeneracy(points, set, model, threshold, rng, out, fits) } -> std::same_as<int>;
};

template <class M>
concept HasOtherMinimum = requires(const PointMatrix& points, double threshold, typename M::Parameters* model,
                                   int* fits) {
  { M::OtherMinimum(points, threshold, model, model, fits) } -> std::same_as<bool>;
};

template <class M>
concept HasRivals = requires {
  requires M::kHasRivals;
};

/// A model with unknown focal lengths, of which priors may be given: `FitFrom` and `Refine` with their share, and the
/// posterior.
template <class M>
concept HasFocalPosterior = requires(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                                     const FocalPriors& priors, typename M::Parameters* model, FocalPosteriors* out) {
  { M::Marginalise(points, weights, loss, priors, model, out) } -> std::same_as<bool>;
  { M::FitFrom(points, weights, priors, model) } -> std::same_as<bool>;
  { M::Refine(points, weights, loss, priors, model) } -> std::same_as<bool>;
};

/// How many dimensions what `Residual` is the length of has: kResidualDimension, or 1.
template <MinimalModel Model>
constexpr int ResidualDimension() {
  if constexpr (requires { Model::kResidualDimension; }) return Model::kResidualDimension;
  return 1;
}

/// The free parameters of a model, of as many residuals as that.
template <MinimalModel Model>
constexpr int FreeParameters() {
  if constexpr (requires { Model::kFreedom; }) return Model::kFreedom;
  return ResidualDimension<Model>() * Model::kMinimalSize;
}

/// Degrees of freedom that MAGSAC++ takes for a model's residual.
template <MinimalModel Model>
constexpr int ResidualDof() {
  if constexpr (requires { Model::kResidualDof; }) return Model::kResidualDof;
  return 4;
}

/// kOk, or why the points cannot be estimated from: too few, non-finite, all equal or of too low rank.
template <MinimalModel Model>
Status CheckPoints(const PointMatrix& points) {
  if (points.rows() < Model::kMinimalSize) return Status::kTooFewPoints;
  if (points.cols() != Model::kDimension || !points.allFinite()) return Status::kDegenerate;
  if constexpr (requires { Model::Determined(points); }) {
    if (!Model::Determined(points)) return Status::kDegenerate;
  }
  return Status::kOk;
}

}  // namespace diffsac
