#pragma once

#include <Eigen/Core>
#include <concepts>

#include "diffsac/geometry/points.h"
#include "diffsac/ransac/local/numeric_fit.h"
#include "diffsac/ransac/model_hooks.h"

namespace diffsac::ransac {

/// What ransac::Search (search.h) asks of a model, all of it static:
///
///   using Parameters                     fixed-size Eigen column vector of doubles
///   kDimension                           numbers of a point
///   kMinimalSize                         γ, points of a minimal set
///   int SolveMinimal(points, set, out)   solves the rows set[0 .. γ) of the N × kDimension points; writes up to
///                                        kMaxSolutions models to out and returns how many, 0 of a degenerate set
///   double Residual(model, point)        unsigned distance, in the unit of Options::max_residual
///
/// and what it may have:
///
///   kMaxSolutions                        1 when absent
///   bool Fit(points, weights, out)       least squares with N weights ≥ 0; false when the points determine no model
///   bool FitFrom(points, weights, model) the same from *model, which stays where it returns false
///   kFreeParameters = true               every vector of parameters is a model, so that least squares may move each of
///                                        them: Residual's numeric derivatives then stand in for Fit and for Refine
///
/// and the hooks of model_hooks.h. Without any of Fit, FitFrom and kFreeParameters the best minimal model is the
/// result. Functions depend on their arguments alone, and may be called by several threads at once.
template <class M>
concept OwnModel = requires(const PointMatrix& points, const int* set, typename M::Parameters* out,
                            const typename M::Parameters& model, const double* point) {
  { M::kDimension } -> std::convertible_to<int>;
  { M::kMinimalSize } -> std::convertible_to<int>;
  { M::SolveMinimal(points, set, out) } -> std::same_as<int>;
  { M::Residual(model, point) } -> std::same_as<double>;
};

template <class M>
concept HasFit = requires(const PointMatrix& points, const Eigen::VectorXd& weights, typename M::Parameters* model) {
  { M::Fit(points, weights, model) } -> std::same_as<bool>;
};

template <class M>
concept HasFreeParameters = requires {
  requires M::kFreeParameters;
};

/// A model with what its author left out: a MinimalModel.
template <OwnModel M>
struct Completed : M {
  using Parameters = typename M::Parameters;
  static constexpr bool kFitsNumerically = HasFreeParameters<M> && !HasFit<M> && !HasFitFrom<M>;
  static constexpr bool kUsualPolicies = true;
  static constexpr bool kFits = HasFit<M> || HasFitFrom<M> || HasFreeParameters<M>;
  static constexpr int kMaxSolutions = [] {
    if constexpr (requires { M::kMaxSolutions; }) return M::kMaxSolutions;
    return 1;
  }();

  /// Nothing without a start.
  static bool Fit([[maybe_unused]] const PointMatrix& points, [[maybe_unused]] const Eigen::VectorXd& weights,
                  [[maybe_unused]] Parameters* out) {
    if constexpr (HasFit<M>) return M::Fit(points, weights, out);
    return false;
  }

  static bool FitFrom(const PointMatrix& points, const Eigen::VectorXd& weights,
                      Parameters* model) requires(HasFitFrom<M> || kFitsNumerically) {
    constexpr int kSteps = 10;
    if constexpr (HasFitFrom<M>) return M::FitFrom(points, weights, model);
    return NumericFit<M>(points, weights, RobustLoss{}).Minimize(kSteps, model);
  }

  static bool Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                     Parameters* model, int steps) requires(HasRobustRefine<M> || HasFreeParameters<M>) {
    if constexpr (HasRobustRefine<M>) return M::Refine(points, weights, loss, model, steps);
    return NumericFit<M>(points, weights, loss).Minimize(steps, model);
  }
};

}  // namespace diffsac::ransac
