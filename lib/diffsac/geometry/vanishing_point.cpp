#include "diffsac/geometry/vanishing_point.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/geometry/levenberg_marquardt.h"
#include "diffsac/geometry/rotation.h"

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

/// Σ weight ρ(r²) on the sphere, over two directions at v.
class SphereProblem {
 public:
  static constexpr int kFreedom = 2;

  SphereProblem(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss)
      : points_(points), weights_(weights), loss_(loss) {}

  /// All is summed up in one pass.
  double Cost(const Eigen::Vector3d& v) {
    const Eigen::Matrix<double, 3, 2> tangent = PlaneBasis(v);
    double cost = 0.0;
    normal_.setZero();
    gradient_.setZero();
    for (Eigen::Index i = 0; i < points_.rows(); ++i) {
      if (!(weights_[i] > 0.0)) continue;
      const Linearization at(v, points_.data() + 4 * i);
      const double square = at.exists ? at.sine * at.sine : 1.0;
      cost += weights_[i] * loss_.Value(square);
      if (!at.exists) continue;
      const double weight = weights_[i] * loss_.Weight(square);
      const Eigen::Vector2d jacobian = tangent.transpose() * at.gradient;
      normal_ += weight * jacobian * jacobian.transpose();
      gradient_ += weight * at.sine * jacobian;
    }
    return cost;
  }
  void Linearize(const Eigen::Vector3d&, Eigen::Matrix2d* normal, Eigen::Vector2d* gradient) const {
    *normal = normal_;
    *gradient = gradient_;
  }
  static Eigen::Vector2d Solve(const Eigen::Matrix2d& damped, const Eigen::Vector2d& right) {
    const double determinant = damped.determinant();
    if (!(determinant > 0.0)) return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    return Eigen::Vector2d(damped(1, 1) * right[0] - damped(0, 1) * right[1],
                           damped(0, 0) * right[1] - damped(0, 1) * right[0]) /
           determinant;
  }
  static Eigen::Vector3d Retract(const Eigen::Vector3d& v, const Eigen::Vector2d& step) {
    return (v + PlaneBasis(v) * step).normalized();
  }

 private:
  const PointMatrix& points_;
  const Eigen::VectorXd& weights_;
  const RobustLoss& loss_;
  Eigen::Matrix2d normal_;
  Eigen::Vector2d gradient_;
};

/// True when the model moved.
bool MinimizeOnSphere(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss, int steps,
                      Eigen::Vector3d* model) {
  Eigen::Vector3d v = model->normalized();
  SphereProblem problem(points, weights, loss);
  if (!Minimize(problem, {.steps = steps}, &v).moved) return false;
  *model = v;
  return true;
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
  MinimizeOnSphere(points, weights, RobustLoss{}, kMostRefineSteps, &model);
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
  return usable && MinimizeOnSphere(points, weights, loss, steps, model);
}

}  // namespace diffsac
