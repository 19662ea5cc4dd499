#include "diffsac/geometry/refine.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/homography_sampson.h"
#include "diffsac/geometry/manifolds.h"
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

/// First-order distances from a homography.
struct HomographySampsonResiduals {
  static void Distances(const Matrix3Parameters& model, const double* const* columns, int count, double* out) {
    HomographySampsonDistances(model.data(), columns, 0, count, out);
  }
  static NormalEquations Equations(const Matrix3Parameters& model, const double* const* columns, const double* weights,
                                   int count) {
    return SumHomographySampsonEquations(model.data(), columns, weights, count);
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

bool Collect(const PointMatrix& points, const Eigen::VectorXd& weights, const PairNormalization& normalization,
             Observations* out) {
  std::vector<int> rows(points.rows());
  int count = 0;
  for (int i = 0; i < static_cast<int>(rows.size()); ++i) {
    rows[count] = i;
    count += weights[i] > 0.0 ? 1 : 0;
  }
  out->points.resize(count, Eigen::NoChange);
  out->weights.resize(count);
  for (int i = 0; i < count; ++i) {
    double point[4];
    normalization.Apply(points.data() + 4 * static_cast<Eigen::Index>(rows[i]), point);
    for (int j = 0; j < 4; ++j) out->points(i, j) = point[j];
    out->weights[i] = weights[rows[i]];
  }
  return out->points.allFinite();
}

/// Checks, normalises with one scale for both images (so that distances in both keep their proportion) and collects.
Status Prepare(const PointMatrix& points, const Eigen::VectorXd& weights, int min_points, bool normalize,
               const Matrix3Parameters& model, PairNormalization* normalization, Observations* observations) {
  if (points.cols() != 4 || weights.size() != points.rows() || !model.allFinite() || !(model.norm() > 0.0))
    return Status::kDegenerate;
  if (weights.size() > 0 && !(weights.minCoeff() >= 0.0 && weights.allFinite())) return Status::kDegenerate;
  if ((weights.array() > 0.0).count() < min_points) return Status::kTooFewPoints;
  *normalization = {};
  if (normalize) {
    WeightedPairs pairs;
    if (!pairs.Gather(points, weights, min_points)) return Status::kDegenerate;
    *normalization = pairs.normalization();
    normalization->first.scale = normalization->second.scale =
        std::sqrt(normalization->first.scale * normalization->second.scale);
  }
  return Collect(points, weights, *normalization, observations) ? Status::kOk : Status::kDegenerate;
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
    RefineNormalizedHomography<HomographySampsonResiduals>(observations, options, normalization, &report, model);
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
