#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "diffsac/geometry/robust_loss.h"

namespace diffsac {

/// How Levenberg-Marquardt damps its steps, and when it ends.
struct LevenbergOptions {
  int steps = kMostRefineSteps;  ///< Tried at most, taken or not.
  double tolerance = 1e-10;      ///< Ends once a step lowers the cost by a smaller share.
  /// Of the trace, on the diagonal: keeps directions that the cost does not see where they are.
  double floor = 1e-15;
  double least_damping = 0.0;
  /// Ends as well once a step can win no more than that share to second order, which saves a pass over the points, or
  /// is shorter than `tolerance`.
  bool by_promise = false;
};

struct LevenbergResult {
  int steps = 0;            ///< Tried.
  double first_cost = 0.0;  ///< At the start ...
  double last_cost = 0.0;   ///< ... and at the end: less where `moved`, else the same.
  bool moved = false;
};

/// Minimises a cost from *state; a step is taken only where it lowers it. `Problem` has
///   kFreedom                            of a step
///   Cost(state)
///   Linearize(state, normal, gradient)  Gauss-Newton's matrix and half the gradient over steps, at a state whose cost
///                                       was asked for last
///   Solve(damped, right)                damped⁻¹ right; not finite where there is none
///   Retract(state, step)                the state a step away
template <class Problem, class State>
LevenbergResult Minimize(Problem& problem, const LevenbergOptions& options, State* state) {
  using Vector = Eigen::Matrix<double, Problem::kFreedom, 1>;
  using Matrix = Eigen::Matrix<double, Problem::kFreedom, Problem::kFreedom>;
  constexpr double kMostDamping = 1e10;
  LevenbergResult result;
  result.first_cost = result.last_cost = problem.Cost(*state);
  double damping = 1e-4;
  bool linearized = false;
  Matrix normal = Matrix::Zero();
  Vector gradient = Vector::Zero();
  while (result.steps < options.steps && damping < kMostDamping) {
    if (!linearized) problem.Linearize(*state, &normal, &gradient);
    linearized = true;
    ++result.steps;
    Matrix damped = normal;
    damped.diagonal() += damping * normal.diagonal() + Vector::Constant(options.floor * normal.trace());
    const Vector step = Problem::Solve(damped, -gradient);
    if (!step.allFinite()) break;
    if (options.by_promise && !(-step.dot(2.0 * gradient + normal * step) > options.tolerance * result.last_cost))
      break;
    const State candidate = problem.Retract(*state, step);
    const double cost = problem.Cost(candidate);
    if (cost < result.last_cost) {
      const double gain = result.last_cost - cost;
      *state = candidate;
      result.last_cost = cost;
      result.moved = true;
      linearized = false;
      damping = std::max(damping * 0.1, options.least_damping);
      if (gain <= options.tolerance * cost) break;
    } else {
      damping *= 10.0;
    }
    if (options.by_promise && step.norm() <= options.tolerance) break;
  }
  return result;
}

}  // namespace diffsac
