#include "diffsac/geometry/refine.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/manifolds.h"
#include "diffsac/geometry/residual_jacobians.h"
#include "diffsac/geometry/sampson_equations.h"
#include "diffsac/geometry/weighted_pairs.h"

namespace diffsac {
namespace {

struct Observation {
  double point[4];
  double weight;
};
using Observations = std::vector<Observation>;

/// Sampson distances: one residual a point. Keeps the points as columns, so that several are handled at a time.
class SampsonCost {
 public:
  SampsonCost(const Observations& observations, const RobustLoss& loss)
      : loss_(loss), columns_(observations.size(), 4), weights_(observations.size()), work_(observations.size()) {
    for (Eigen::Index i = 0; i < weights_.size(); ++i) {
      for (int j = 0; j < 4; ++j) columns_(i, j) = observations[i].point[j];
      weights_[i] = observations[i].weight;
    }
    for (int j = 0; j < 4; ++j) pointers_[j] = columns_.col(j).data();
  }

  double operator()(const Matrix3Parameters& model) {
    Distances(model);
    double sum = 0.0;
    for (Eigen::Index i = 0; i < work_.size(); ++i) sum += weights_[i] * loss_.Value(work_[i] * work_[i]);
    return sum;
  }

  NormalEquations Linearize(const Matrix3Parameters& model) {
    Distances(model);
    for (Eigen::Index i = 0; i < work_.size(); ++i) work_[i] = weights_[i] * loss_.Weight(work_[i] * work_[i]);
    return SumSampsonEquations(model.data(), pointers_, work_.data(), static_cast<int>(work_.size()));
  }

 private:
  void Distances(const Matrix3Parameters& model) {
    SampsonDistances(model.data(), pointers_, 0, static_cast<int>(work_.size()), work_.data());
  }

  RobustLoss loss_;
  Eigen::Matrix<double, Eigen::Dynamic, 4> columns_;
  Eigen::VectorXd weights_;
  Eigen::VectorXd work_;  ///< distances, then robust weights
  const double* pointers_[4];
};

/// Sums over transfer residuals. With q qᵀ (6 values) times 1, p_0, p_1 and |p|², the blocks of JᵀJ are
/// [1, 0, −p_0; 0, 1, −p_1; −p_0, −p_1, |p|²] ⊗ q qᵀ.
class TransferSums {
 public:
  void Add(const TransferResidual& t, double weight) {
    const double* q = t.q;
    const double square[6] = {q[0] * q[0], q[0] * q[1], q[0] * q[2], q[1] * q[1], q[1] * q[2], q[2] * q[2]};
    const double factor[4] = {weight, weight * t.p[0], weight * t.p[1], weight * (t.p[0] * t.p[0] + t.p[1] * t.p[1])};
    const double pull[3] = {weight * t.r[0], weight * t.r[1], -weight * (t.r[0] * t.p[0] + t.r[1] * t.p[1])};
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 6; ++k) sums_[j][k] += factor[j] * square[k];
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) gradient_[3 * j + k] += pull[j] * q[k];
  }

  NormalEquations Equations() const {
    constexpr int kPair[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    NormalEquations result{Eigen::Matrix<double, 9, 9>::Zero(), Eigen::Map<const Matrix3Parameters>(gradient_)};
    Eigen::Matrix<double, 9, 9>& m = result.normal;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const int k = kPair[i][j];
        m(i, j) = m(3 + i, 3 + j) = sums_[0][k];
        m(i, 6 + j) = m(6 + i, j) = -sums_[1][k];
        m(3 + i, 6 + j) = m(6 + i, 3 + j) = -sums_[2][k];
        m(6 + i, 6 + j) = sums_[3][k];
      }
    }
    return result;
  }

 private:
  double sums_[4][6] = {};
  double gradient_[9] = {};
};

/// Transfer to the second image alone.
struct TransferCost {
  const Observations& observations;
  RobustLoss loss;

  double operator()(const Matrix3Parameters& model) const {
    double sum = 0.0;
    for (const auto& [p, weight] : observations)
      sum += weight * loss.Value(TransferResidual(model.data(), p[0], p[1], p[2], p[3]).Square());
    return sum;
  }

  NormalEquations Linearize(const Matrix3Parameters& model) const {
    TransferSums sums;
    for (const auto& [p, weight] : observations) {
      const TransferResidual t(model.data(), p[0], p[1], p[2], p[3]);
      const double w = weight * loss.Weight(t.Square());
      if (w > 0.0) sums.Add(t, w);
    }
    return sums.Equations();
  }
};

/// Both directions, each with half the weight; the second is a transfer by the adjugate, brought back by its
/// derivative.
struct SymmetricCost {
  const Observations& observations;
  RobustLoss loss;

  double operator()(const Matrix3Parameters& model) const {
    const Matrix3Parameters back = AdjugateOf(model);
    double sum = 0.0;
    for (const auto& [p, weight] : observations) {
      const double forward = TransferResidual(model.data(), p[0], p[1], p[2], p[3]).Square();
      const double backward = TransferResidual(back.data(), p[2], p[3], p[0], p[1]).Square();
      sum += weight * loss.Value(0.5 * (forward + backward));
    }
    return sum;
  }

  NormalEquations Linearize(const Matrix3Parameters& model) const {
    const Matrix3Parameters back = AdjugateOf(model);
    TransferSums forward_sums, backward_sums;
    for (const auto& [p, weight] : observations) {
      const TransferResidual forward(model.data(), p[0], p[1], p[2], p[3]);
      const TransferResidual backward(back.data(), p[2], p[3], p[0], p[1]);
      const double w = 0.5 * weight * loss.Weight(0.5 * (forward.Square() + backward.Square()));
      if (!(w > 0.0)) continue;
      forward_sums.Add(forward, w);
      backward_sums.Add(backward, w);
    }
    const Eigen::Matrix<double, 9, 9> chain = AdjugateDerivative(model);
    NormalEquations result = forward_sums.Equations();
    const NormalEquations second = backward_sums.Equations();
    result.normal += chain.transpose() * second.normal * chain;
    result.gradient += chain.transpose() * second.gradient;
    return result;
  }
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
    if (!step.allFinite()) break;
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
  out->reserve(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!(weights[i] > 0.0)) continue;
    Observation o{{}, weights[i]};
    normalization.Apply(points.data() + 4 * i, o.point);
    for (const double value : o.point)
      if (!std::isfinite(value)) return false;
    out->push_back(o);
  }
  return true;
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

template <class Cost>
void RefineNormalizedHomography(const Observations& observations, const RefineOptions& options,
                                const PairNormalization& n, RefineReport* report, Matrix3Parameters* model) {
  const double scale = n.first.scale;
  HomographyManifold state =
      HomographyManifold::From(AsParameters(n.second.Matrix() * AsMatrix(*model) * n.first.Inverse()));
  const bool moved = Minimize(Cost{observations, Scaled(options.loss, scale)}, options, &state, report);
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
                              HomographyError error, Matrix3Parameters* model) {
  RefineReport report;
  PairNormalization normalization;
  Observations observations;
  report.status = Prepare(points, weights, 4, true, *model, &normalization, &observations);
  if (report.status != Status::kOk) return report;
  if (error == HomographyError::kTransfer) {
    RefineNormalizedHomography<TransferCost>(observations, options, normalization, &report, model);
  } else {
    RefineNormalizedHomography<SymmetricCost>(observations, options, normalization, &report, model);
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
  const bool moved = Minimize(SampsonCost(observations, Scaled(options.loss, scale)), options, &state, &report);
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
  if (Minimize(SampsonCost(observations, options.loss), options, &state, &report))
    Keep(state.Parameters(), &report, model);
  return report;
}

}  // namespace diffsac
