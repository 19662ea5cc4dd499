#include "diffsac/geometry/vanishing_point.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace diffsac {
namespace {

/// Two lines whose normals' cross product is smaller are one.
constexpr double kMinSine = 1e-9;
/// The second-least eigenvalue of the normals' scatter, relative to the largest, above which they determine a point.
constexpr double kMinGap = 1e-14;

/// The unit normal of the plane through the camera's centre and a segment; 0 for a segment of length 0.
Eigen::Vector3d NormalOf(const double* p) {
  const Eigen::Vector3d normal(p[1] - p[3], p[2] - p[0], p[0] * p[3] - p[1] * p[2]);
  const double length = normal.norm();
  return length > 0.0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
}

Eigen::Matrix3d Scatter(const PointMatrix& points, const Eigen::VectorXd& weights) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (!(weights[i] > 0.0)) continue;
    const Eigen::Vector3d normal = NormalOf(points.data() + 4 * i);
    scatter += weights[i] * normal * normal.transpose();
  }
  return scatter;
}

/// The direction that is most orthogonal to all normals; false where it is not unique.
bool LeastDirection(const Eigen::Matrix3d& scatter, Eigen::Vector3d* direction) {
  if (!scatter.allFinite() || !(scatter.trace() > 0.0)) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter / scatter.trace());
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()[1] > kMinGap)) return false;
  *direction = solver.eigenvectors().col(0);
  return true;
}

/// A signed residual and its derivative by v.
struct Linearization {
  double sine = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  bool exists = false;

  Linearization(const Eigen::Vector3d& v, const double* p) {
    const Eigen::Vector2d middle(0.5 * (p[0] + p[2]), 0.5 * (p[1] + p[3]));
    const Eigen::Vector2d along(p[2] - p[0], p[3] - p[1]), towards = v.head<2>() - v[2] * middle;
    const double length = along.norm(), distance = towards.norm();
    exists = length > 0.0 && distance > 0.0;
    if (!exists) return;
    const Eigen::Vector2d d = along / length, w = towards / distance;
    sine = d[0] * w[1] - d[1] * w[0];
    const Eigen::Vector2d by_towards = (Eigen::Vector2d(-d[1], d[0]) - sine * w) / distance;
    gradient << by_towards, -by_towards.dot(middle);
  }
};

/// Two directions of the sphere at v.
Eigen::Matrix<double, 3, 2> Tangent(const Eigen::Vector3d& v) {
  Eigen::Matrix<double, 3, 2> tangent;
  tangent.col(0) = v.unitOrthogonal();
  tangent.col(1) = v.cross(tangent.col(0));
  return tangent;
}

/// Σ weight ρ(r²), and over the tangent its gradient and Gauss-Newton matrix.
struct Equations {
  double cost = 0.0;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();

  Equations(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss, const Eigen::Vector3d& v,
            const Eigen::Matrix<double, 3, 2>& tangent) {
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      if (!(weights[i] > 0.0)) continue;
      const Linearization at(v, points.data() + 4 * i);
      const double square = at.exists ? at.sine * at.sine : 1.0;
      cost += weights[i] * loss.Value(square);
      if (!at.exists) continue;
      const double weight = weights[i] * loss.Weight(square);
      const Eigen::Vector2d jacobian = tangent.transpose() * at.gradient;
      normal += weight * jacobian * jacobian.transpose();
      gradient += weight * at.sine * jacobian;
    }
  }
};

bool Minimize(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss, int steps,
              Eigen::Vector3d* model) {
  constexpr double kTolerance = 1e-10, kMostDamping = 1e10;
  Eigen::Vector3d v = model->normalized();
  Eigen::Matrix<double, 3, 2> tangent = Tangent(v);
  Equations now(points, weights, loss, v, tangent);
  double damping = 1e-4;
  bool moved = false;
  for (int step = 0; step < steps && damping < kMostDamping; ++step) {
    Eigen::Matrix2d damped = now.normal;
    damped.diagonal() += damping * now.normal.diagonal() + Eigen::Vector2d::Constant(1e-15 * now.normal.trace());
    const double determinant = damped.determinant();
    if (!(determinant > 0.0)) break;
    const Eigen::Vector2d change = Eigen::Vector2d(damped(0, 1) * now.gradient[1] - damped(1, 1) * now.gradient[0],
                                                   damped(0, 1) * now.gradient[0] - damped(0, 0) * now.gradient[1]) /
                                   determinant;
    const Eigen::Vector3d candidate = (v + tangent * change).normalized();
    if (!candidate.allFinite()) break;
    const Eigen::Matrix<double, 3, 2> candidate_tangent = Tangent(candidate);
    const Equations there(points, weights, loss, candidate, candidate_tangent);
    if (!(there.cost < now.cost)) {
      damping *= 10.0;
      continue;
    }
    const double gain = now.cost - there.cost;
    v = candidate;
    tangent = candidate_tangent;
    now = there;
    moved = true;
    if (gain <= kTolerance * now.cost) break;
    damping *= 0.1;
  }
  if (moved) *model = v;
  return moved;
}

}  // namespace

int VanishingPoint::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  const Eigen::Vector3d meeting = NormalOf(points.data() + 4 * static_cast<Eigen::Index>(set[0]))
                                      .cross(NormalOf(points.data() + 4 * static_cast<Eigen::Index>(set[1])));
  const double sine = meeting.norm();
  if (!(sine > kMinSine) || !std::isfinite(sine)) return 0;
  *out = meeting / sine;
  return 1;
}

bool VanishingPoint::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  if (points.cols() != kDimension || weights.size() != points.rows()) return false;
  if (!weights.allFinite() || (weights.array() < 0.0).any() || (weights.array() > 0.0).count() < kMinimalSize)
    return false;
  Parameters model;
  if (!LeastDirection(Scatter(points, weights), &model)) return false;
  Minimize(points, weights, RobustLoss{}, kMostRefineSteps, &model);
  *out = model;
  return true;
}

bool VanishingPoint::Determined(const PointMatrix& points) {
  if (points.cols() != kDimension || points.rows() < kMinimalSize || !points.allFinite()) return false;
  Parameters direction;
  return LeastDirection(Scatter(points, Eigen::VectorXd::Ones(points.rows())), &direction);
}

double VanishingPoint::Residual(const Parameters& model, const double* point) {
  double residual = 0.0;
  const double* const columns[4] = {point, point + 1, point + 2, point + 3};
  Residuals(model, columns, 0, 1, &residual);
  return residual;
}

void VanishingPoint::Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out) {
  const double vx = model[0], vy = model[1], half = 0.5 * model[2];
  const double *x1 = columns[0] + begin, *y1 = columns[1] + begin, *x2 = columns[2] + begin, *y2 = columns[3] + begin;
  const int count = end - begin;
  for (int i = 0; i < count; ++i) {
    const double dx = x2[i] - x1[i], dy = y2[i] - y1[i];
    const double wx = vx - half * (x1[i] + x2[i]), wy = vy - half * (y1[i] + y2[i]);
    const double cross = dx * wy - dy * wx, product = (dx * dx + dy * dy) * (wx * wx + wy * wy);
    // Rounding aside at most 1; 0/0 is 1, too.
    const double square = cross * cross / product;
    out[i] = square < 1.0 ? std::sqrt(square) : 1.0;
  }
}

bool VanishingPoint::Refine(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                            Parameters* model, int steps) {
  const bool usable = points.cols() == kDimension && weights.size() == points.rows() && points.allFinite() &&
                      weights.allFinite() && model->allFinite() && model->norm() > 0.0;
  return usable && Minimize(points, weights, loss, steps, model);
}

bool VanishingPoint::Refine(const PointMatrix& points, double threshold, Parameters* model) {
  if (!(threshold > 0.0) || !std::isfinite(threshold)) return false;
  return Refine(points, Eigen::VectorXd::Ones(points.rows()), RobustLoss{LossKind::kTruncated, threshold}, model);
}

}  // namespace diffsac
