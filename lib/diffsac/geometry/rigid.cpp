#include "diffsac/geometry/rigid.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/covariance.h"
#include "diffsac/geometry/levenberg_marquardt.h"
#include "diffsac/geometry/point_spread.h"
#include "diffsac/geometry/refine.h"
#include "diffsac/geometry/rotation.h"
#include "diffsac/geometry/some_rows.h"
#include "diffsac/geometry/svd3.h"
#include "diffsac/geometry/vector_clones.h"

namespace diffsac {
namespace {

using Parameters = Rigid::Parameters;
using PointMap = Eigen::Map<const Eigen::Vector3d>;

PointMap From(const PointMatrix& points, Eigen::Index i) { return PointMap(points.data() + 6 * i); }
PointMap To(const PointMatrix& points, Eigen::Index i) { return PointMap(points.data() + 6 * i + 3); }

/// Umeyama's fit of the rows that `for_each` calls its function with, as often as it is asked to: (row, weight).
template <bool kScaled, class ForEach>
bool FitRows(const PointMatrix& points, const ForEach& for_each, Parameters* out) {
  constexpr double kLine = 1e-9;  // Of the products of two clouds' spreads.
  double total = 0.0, spread = 0.0;
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = from;
  for_each([&](Eigen::Index i, double weight) {
    total += weight;
    from += weight * From(points, i);
    to += weight * To(points, i);
  });
  if (!(total > 0.0)) return false;
  from /= total;
  to /= total;
  Eigen::Matrix3d product = Eigen::Matrix3d::Zero();
  for_each([&](Eigen::Index i, double weight) {
    const Eigen::Vector3d x = From(points, i) - from;
    product += weight * (To(points, i) - to) * x.transpose();
    spread += weight * x.squaredNorm();
  });
  const Svd3 svd = ComputeSvd3(product);
  if (!(svd.values[1] > kLine * svd.values[0]) || !std::isfinite(svd.values[0])) return false;
  const double sign = svd.u.determinant() * svd.v.determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d signs(1.0, 1.0, sign);
  Eigen::Matrix3d turn = svd.u * signs.asDiagonal() * svd.v.transpose();
  if (kScaled) turn *= svd.values.dot(signs) / spread;
  *out = PoseOf(turn, to - turn * from);
  return out->allFinite();
}

/// Σ weight ρ(r²), its gradient and Gauss-Newton matrix.
template <bool kScaled>
struct MotionEquations {
  static constexpr int kFreedom = CloudMotion<kScaled>::kFreedom;
  double cost = 0.0;
  Eigen::Matrix<double, kFreedom, kFreedom> normal = Eigen::Matrix<double, kFreedom, kFreedom>::Zero();
  Eigen::Matrix<double, kFreedom, 1> gradient = Eigen::Matrix<double, kFreedom, 1>::Zero();

  MotionEquations(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                  const Parameters& model, bool linearize) {
    const Eigen::Matrix3d turn = RotationOf(model);
    const Eigen::Vector3d shift = TranslationOf(model);
    Eigen::Matrix<double, 3, kFreedom> jacobian;
    jacobian.template middleCols<3>(3).setIdentity();
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      if (!(weights[i] > 0.0)) continue;
      const Eigen::Vector3d turned = turn * From(points, i), residual = turned + shift - To(points, i);
      const double square = residual.squaredNorm(), weight = weights[i] * loss.Weight(square);
      cost += weights[i] * loss.Value(square);
      if (!linearize || !(weight > 0.0)) continue;
      jacobian.template leftCols<3>() = -CrossMatrix(turned);
      if constexpr (kScaled) jacobian.col(6) = turned;
      normal += weight * jacobian.transpose() * jacobian;
      gradient += weight * jacobian.transpose() * residual;
    }
  }
};

template <bool kScaled>
struct MotionProblem {
  static constexpr int kFreedom = CloudMotion<kScaled>::kFreedom;
  using Vector = Eigen::Matrix<double, kFreedom, 1>;
  using Matrix = Eigen::Matrix<double, kFreedom, kFreedom>;
  const PointMatrix& points;
  const Eigen::VectorXd& weights;
  const RobustLoss& loss;

  double Cost(const Parameters& model) const {
    return MotionEquations<kScaled>(points, weights, loss, model, false).cost;
  }
  void Linearize(const Parameters& model, Matrix* normal, Vector* gradient) const {
    const MotionEquations<kScaled> equations(points, weights, loss, model, true);
    *normal = equations.normal;
    *gradient = equations.gradient;
  }
  static Vector Solve(const Matrix& damped, const Vector& right) { return damped.ldlt().solve(right); }
  static Parameters Retract(const Parameters& model, const Vector& step) {
    Eigen::Matrix3d turn = ExpRotation(step.template head<3>()).toRotationMatrix() * RotationOf(model);
    if constexpr (kScaled) turn *= std::exp(step[6]);
    return PoseOf(turn, TranslationOf(model) + step.template segment<3>(3));
  }
};

DIFFSAC_VECTOR_CLONES void MotionResiduals(const double* m, const double* const* columns, int begin, int end,
                                           double* out) {
  const double *x = columns[0], *y = columns[1], *z = columns[2], *u = columns[3], *v = columns[4], *w = columns[5];
  for (int i = begin; i < end; ++i) {
    const double a = m[0] * x[i] + m[1] * y[i] + m[2] * z[i] + m[3] - u[i];
    const double b = m[4] * x[i] + m[5] * y[i] + m[6] * z[i] + m[7] - v[i];
    const double c = m[8] * x[i] + m[9] * y[i] + m[10] * z[i] + m[11] - w[i];
    out[i - begin] = std::sqrt(a * a + b * b + c * c);
  }
}

bool OnOneLine(const PointMatrix& points) {
  constexpr double kFlat = 1e-6;
  const PointSpread spread = SpreadOf(points);
  return !(spread.sides[1] > kFlat * spread.sides[2]);
}

/// Of many points some, evenly, mostly say that they are on none.
bool CloudOnOneLine(const PointMatrix& matches, int first) {
  constexpr Eigen::Index kSome = 100'000;
  const auto some = SomeRows(matches.rows(), kSome);
  return OnOneLine(matches(some, Eigen::seqN(first, 3))) &&
         (some.size() == matches.rows() || OnOneLine(matches.middleCols(first, 3)));
}

}  // namespace

template <bool kScaled>
int CloudMotion<kScaled>::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  const auto rows = [&](const auto& add) {
    for (int i = 0; i < kMinimalSize; ++i) add(set[i], 1.0);
  };
  return FitRows<kScaled>(points, rows, out) ? 1 : 0;
}

template <bool kScaled>
bool CloudMotion<kScaled>::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  if (points.cols() != kDimension || weights.size() != points.rows()) return false;
  return FitRows<kScaled>(
      points,
      [&](const auto& add) {
        for (Eigen::Index i = 0; i < points.rows(); ++i)
          if (weights[i] > 0.0) add(i, weights[i]);
      },
      out);
}

template <bool kScaled>
bool CloudMotion<kScaled>::Determined(const PointMatrix& points) {
  return points.rows() >= kMinimalSize && points.cols() == kDimension && points.allFinite() &&
         !CloudOnOneLine(points, 0) && !CloudOnOneLine(points, 3);
}

template <bool kScaled>
double CloudMotion<kScaled>::Residual(const Parameters& model, const double* point) {
  const double* const columns[kDimension] = {point, point + 1, point + 2, point + 3, point + 4, point + 5};
  double residual = 0.0;
  MotionResiduals(model.data(), columns, 0, 1, &residual);
  return residual;
}

template <bool kScaled>
void CloudMotion<kScaled>::Residuals(const Parameters& model, const double* const* columns, int begin, int end,
                                     double* out) {
  MotionResiduals(model.data(), columns, begin, end, out);
}

template <bool kScaled>
bool CloudMotion<kScaled>::Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                                  Parameters* model, int steps) {
  if (points.cols() != kDimension || weights.size() != points.rows() || !model->allFinite()) return false;
  // Of a loss that ends, few matches have a pull.
  std::vector<Eigen::Index> rows;
  const bool ends = loss.kind == LossKind::kTruncated || loss.kind == LossKind::kMarginalised;
  const Eigen::VectorXd residuals = RowResiduals<CloudMotion<kScaled>>(points, *model);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (!ends || residuals[i] <= kRefineReach * loss.scale) rows.push_back(i);
  const PointMatrix some = points(rows, Eigen::all);
  const Eigen::VectorXd weights_of_some = weights(rows);
  MotionProblem<kScaled> problem{some, weights_of_some, loss};
  Parameters refined = *model;
  if (!Minimize(problem, {.steps = steps}, &refined).moved || !refined.allFinite()) return false;
  *model = refined;
  return true;
}

template <bool kScaled>
typename CloudMotion<kScaled>::Information CloudMotion<kScaled>::InformationOf(const PointMatrix& points,
                                                                               const Eigen::VectorXd& weights,
                                                                               const Parameters& model) {
  return MotionEquations<kScaled>(points, weights, RobustLoss{}, model, true).normal;
}

double ScaleOf(const Similarity::Parameters& model) { return std::cbrt(RotationOf(model).determinant()); }

template <bool kScaled>
std::optional<Eigen::MatrixXd> MotionCovariance(const PointMatrix& points, const Rigid::Parameters& model,
                                                const FitConditions& fit) {
  using Model = CloudMotion<kScaled>;
  return CovarianceOfFit(
      RowResiduals<Model>(points, model), Model::kResidualDimension, fit,
      [&](const Eigen::VectorXd& weights) { return Eigen::MatrixXd(Model::InformationOf(points, weights, model)); });
}

template std::optional<Eigen::MatrixXd> MotionCovariance<false>(const PointMatrix&, const Rigid::Parameters&,
                                                                const FitConditions&);
template std::optional<Eigen::MatrixXd> MotionCovariance<true>(const PointMatrix&, const Rigid::Parameters&,
                                                               const FitConditions&);

template struct CloudMotion<false>;
template struct CloudMotion<true>;

}  // namespace diffsac
