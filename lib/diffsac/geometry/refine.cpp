#include "diffsac/geometry/refine.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/residual_jacobians.h"
#include "diffsac/geometry/robust_loss_sums.h"
#include "diffsac/geometry/sampson_equations.h"
#include "diffsac/geometry/transfer_equations.h"
#include "diffsac/geometry/weighted_pairs.h"

namespace diffsac {
namespace {

/// Normalised points of positive weight, as columns.
struct Observations {
  Eigen::Matrix<double, Eigen::Dynamic, 4> points;
  Eigen::VectorXd weights;

  int size() const { return static_cast<int>(weights.size()); }
};

/// Sampson distances: one residual a point.
struct SampsonResiduals {
  static void Distances(const Matrix3Parameters& model, const double* const* columns, int count, double* out) {
    SampsonDistances(model.data(), columns, 0, count, out);
  }
  static NormalEquations Equations(const Matrix3Parameters& model, const double* const* columns, const double* weights,
                                   int count) {
    return SumSampsonEquations(model.data(), columns, weights, count);
  }
};

/// Transfer to the second image alone.
struct TransferResiduals {
  static void Distances(const Matrix3Parameters& model, const double* const* columns, int count, double* out) {
    TransferDistances(model.data(), columns, count, out);
  }
  static NormalEquations Equations(const Matrix3Parameters& model, const double* const* columns, const double* weights,
                                   int count) {
    return SumTransferEquations(model.data(), columns, weights, count);
  }
};

/// Both directions, each with half the weight; the second is a transfer by the adjugate, brought back by its
/// derivative.
struct SymmetricResiduals {
  static void Distances(const Matrix3Parameters& model, const double* const* columns, int count, double* out) {
    Homography::Residuals(model, columns, 0, count, out);
  }
  static NormalEquations Equations(const Matrix3Parameters& model, const double* const* columns, const double* weights,
                                   int count) {
    const Matrix3Parameters back = AdjugateOf(model);
    const double* swapped[4] = {columns[2], columns[3], columns[0], columns[1]};
    NormalEquations result = SumTransferEquations(model.data(), columns, weights, count);
    const NormalEquations second = SumTransferEquations(back.data(), swapped, weights, count);
    const Eigen::Matrix<double, 9, 9> chain = AdjugateDerivative(model);
    result.normal = 0.5 * (result.normal + chain.transpose() * second.normal * chain);
    result.gradient = 0.5 * (result.gradient + chain.transpose() * second.gradient);
    return result;
  }
};

/// The robust cost of a model and its normal equations; several points are handled at a time. Borrows observations.
template <class Residuals>
class RobustCost {
 public:
  RobustCost(const Observations& observations, const RobustLoss& loss)
      : loss_(loss), observations_(observations), distances_(observations.size()), work_(observations.size()) {
    for (int j = 0; j < 4; ++j) columns_[j] = observations.points.col(j).data();
  }

  double operator()(const Matrix3Parameters& model) {
    Evaluate(model);
    return SumLoss(loss_, distances_.data(), observations_.weights.data(), observations_.size());
  }

  NormalEquations Linearize(const Matrix3Parameters& model) {
    Evaluate(model);
    LossWeights(loss_, distances_.data(), observations_.weights.data(), observations_.size(), work_.data());
    return Residuals::Equations(model, columns_, work_.data(), observations_.size());
  }

 private:
  /// A model is mostly linearised right after its cost was asked for.
  void Evaluate(const Matrix3Parameters& model) {
    if (model == evaluated_) return;
    Residuals::Distances(model, columns_, observations_.size(), distances_.data());
    evaluated_ = model;
  }

  RobustLoss loss_;
  const Observations& observations_;
  const double* columns_[4];
  Eigen::VectorXd distances_, work_;
  Matrix3Parameters evaluated_ = Matrix3Parameters::Zero();  ///< What distances_ are of; 0: nothing.
};

/// Levenberg-Marquardt; a step is taken only where it lowers the cost. True when the model moved.
template <class Manifold, class Cost>
bool Minimize(Cost&& cost, const RefineOptions& options, Manifold* state, RefineReport* report) {
  constexpr int kFreedom = Manifold::kFreedom;
  using Vector = Eigen::Matrix<double, kFreedom, 1>;
  constexpr double kMaxDamping = 1e10, kMinDamping = 1e-10;
  double current = cost(state->Parameters());
  report->initial_cost = current;
  double damping = 1e-4;
  bool moved = false, linearized = false;
  Eigen::Matrix<double, kFreedom, kFreedom> normal;
  Vector gradient;
  while (report->iterations < options.max_iterations && damping < kMaxDamping) {
    if (!linearized) {
      const Eigen::Matrix<double, 9, kFreedom> tangent = state->Tangent();
      const NormalEquations equations = cost.Linearize(state->Parameters());
      normal = tangent.transpose() * equations.normal * tangent;
      gradient = tangent.transpose() * equations.gradient;
      linearized = true;
    }
    ++report->iterations;
    Eigen::Matrix<double, kFreedom, kFreedom> damped = normal;
    // The floor keeps directions that the cost does not see (equal singular values of F) where they are.
    damped.diagonal() += damping * normal.diagonal() + Vector::Constant(1e-12 * normal.trace());
    const Vector step = damped.llt().solve(-gradient);
    // What the step can win at most, to second order, ends the search before another pass over the points.
    const double promised = -step.dot(2.0 * gradient + normal * step);
    if (!step.allFinite() || !(promised > options.relative_tolerance * current)) break;
    const Manifold candidate = state->Retract(step);
    const double lowered = cost(candidate.Parameters());
    if (lowered < current) {
      const double gain = current - lowered;
      *state = candidate;
      current = lowered;
      moved = true;
      linearized = false;
      damping = std::max(damping * 0.1, kMinDamping);
      if (gain <= options.relative_tolerance * current) break;
    } else {
      damping *= 10.0;
    }
    if (step.norm() <= options.relative_tolerance) break;
  }
  report->final_cost = current;
  return moved;
}

/// Checks, normalises with one scale for both images (so that distances in both keep their proportion) and collects.
Status Prepare(const PointMatrix& points, const Eigen::VectorXd& weights, int min_points, bool normalize,
               const Matrix3Parameters& model, PairNormalization* normalization, Observations* observations) {
  if (points.cols() != 4 || !model.allFinite() || !(model.norm() > 0.0)) return Status::kDegenerate;
  WeightedPairs pairs;
  if (!pairs.Collect(points, weights)) return Status::kDegenerate;
  if (pairs.positive() < min_points) return Status::kTooFewPoints;
  *normalization = {};
  if (normalize) {
    if (!pairs.Normalize()) return Status::kDegenerate;
    *normalization = pairs.normalization();
    normalization->first.scale = normalization->second.scale =
        std::sqrt(normalization->first.scale * normalization->second.scale);
  }
  observations->points = normalization->first.scale * pairs.columns().leftCols<4>();
  observations->weights = pairs.columns().col(4);
  return observations->points.allFinite() ? Status::kOk : Status::kDegenerate;
}

/// Brings the costs back from normalised units.
void Rescale(double scale, RefineReport* report) {
  report->initial_cost /= scale * scale;
  report->final_cost /= scale * scale;
}

RobustLoss Scaled(const RobustLoss& loss, double scale) { return {loss.kind, loss.scale * scale, loss.least * scale}; }

/// Sets *model when the refined one is finite; else reports no change.
void Keep(const Matrix3Parameters& refined, RefineReport* report, Matrix3Parameters* model) {
  if (refined.allFinite()) {
    *model = refined;
  } else {
    report->final_cost = report->initial_cost;
  }
}

template <class Residuals>
void RefineNormalizedHomography(const Observations& observations, const RefineOptions& options,
                                const PairNormalization& n, RefineReport* report, Matrix3Parameters* model) {
  const double scale = n.first.scale;
  HomographyManifold state =
      HomographyManifold::From(AsParameters(n.second.Matrix() * AsMatrix(*model) * n.first.Inverse()));
  const bool moved =
      Minimize(RobustCost<Residuals>(observations, Scaled(options.loss, scale)), options, &state, report);
  Rescale(scale, report);
  if (moved) Keep(AsParameters(n.second.Inverse() * AsMatrix(state.Parameters()) * n.first.Matrix()), report, model);
}

}  // namespace

Matrix3Parameters AdjugateOf(const Matrix3Parameters& h) {
  Matrix3Parameters g;
  g << h[4] * h[8] - h[5] * h[7], h[2] * h[7] - h[1] * h[8], h[1] * h[5] - h[2] * h[4],  //
      h[5] * h[6] - h[3] * h[8], h[0] * h[8] - h[2] * h[6], h[2] * h[3] - h[0] * h[5],   //
      h[3] * h[7] - h[4] * h[6], h[1] * h[6] - h[0] * h[7], h[0] * h[4] - h[1] * h[3];
  return g;
}

Eigen::Matrix<double, 9, 9> AdjugateDerivative(const Matrix3Parameters& h) {
  // Every entry is a product less another: g = h[a] h[b] - h[c] h[d].
  constexpr int kTerms[9][4] = {{4, 8, 5, 7}, {2, 7, 1, 8}, {1, 5, 2, 4}, {5, 6, 3, 8}, {0, 8, 2, 6},
                                {2, 3, 0, 5}, {3, 7, 4, 6}, {1, 6, 0, 7}, {0, 4, 1, 3}};
  Eigen::Matrix<double, 9, 9> derivative = Eigen::Matrix<double, 9, 9>::Zero();
  for (int i = 0; i < 9; ++i) {
    const int* t = kTerms[i];
    derivative(i, t[0]) = h[t[1]];
    derivative(i, t[1]) = h[t[0]];
    derivative(i, t[2]) = -h[t[3]];
    derivative(i, t[3]) = -h[t[2]];
  }
  return derivative;
}

RefineReport RefineHomography(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                              HomographyResidual error, Matrix3Parameters* model) {
  RefineReport report;
  PairNormalization normalization;
  Observations observations;
  report.status = Prepare(points, weights, 4, true, *model, &normalization, &observations);
  if (report.status != Status::kOk) return report;
  if (error == HomographyResidual::kTransfer) {
    RefineNormalizedHomography<TransferResiduals>(observations, options, normalization, &report, model);
  } else {
    RefineNormalizedHomography<SymmetricResiduals>(observations, options, normalization, &report, model);
  }
  return report;
}

RefineReport RefineFundamental(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                               Matrix3Parameters* model) {
  RefineReport report;
  PairNormalization n;
  Observations observations;
  report.status = Prepare(points, weights, 7, true, *model, &n, &observations);
  if (report.status != Status::kOk) return report;
  const double scale = n.first.scale;
  FundamentalManifold state =
      FundamentalManifold::From(AsParameters(n.second.Inverse().transpose() * AsMatrix(*model) * n.first.Inverse()));
  const bool moved =
      Minimize(RobustCost<SampsonResiduals>(observations, Scaled(options.loss, scale)), options, &state, &report);
  Rescale(scale, &report);
  if (moved)
    Keep(AsParameters(n.second.Matrix().transpose() * AsMatrix(state.Parameters()) * n.first.Matrix()), &report, model);
  return report;
}

RefineReport RefineEssential(const PointMatrix& points, const Eigen::VectorXd& weights, const RefineOptions& options,
                             Matrix3Parameters* model) {
  RefineReport report;
  PairNormalization identity;
  Observations observations;
  report.status = Prepare(points, weights, 5, false, *model, &identity, &observations);
  if (report.status != Status::kOk) return report;
  EssentialManifold state = EssentialManifold::From(*model);
  if (Minimize(RobustCost<SampsonResiduals>(observations, options.loss), options, &state, &report))
    Keep(state.Parameters(), &report, model);
  return report;
}

}  // namespace diffsac
