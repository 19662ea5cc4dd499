// The non-minimal fit and the refinement of absolute poses.

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/levenberg_marquardt.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/rotation.h"
#include "diffsac/geometry/svd3.h"

namespace diffsac {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The nearest rotation, and the factor by which `matrix` is larger.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix, double* scale) {
  const Svd3 svd = ComputeSvd3(matrix);
  const Eigen::Matrix3d product = svd.u * svd.v.transpose();
  const double sign = product.determinant() < 0.0 ? -1.0 : 1.0;
  *scale = sign * svd.values.mean();
  return sign * product;
}

/// The points of positive weight, the scene's about their mean and turned to its principal axes, widest first.
struct Resection {
  Eigen::Matrix<double, Eigen::Dynamic, 3> scene;
  Eigen::Matrix<double, Eigen::Dynamic, 2> image;
  Eigen::VectorXd weights;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d spread = Eigen::Vector3d::Zero();  ///< Standard deviations along the axes.

  bool Gather(const PointMatrix& points, const Eigen::VectorXd& all_weights) {
    const Eigen::Index count = (all_weights.array() > 0.0).count();
    scene.resize(count, 3);
    image.resize(count, 2);
    weights.resize(count);
    for (Eigen::Index i = 0, next = 0; i < points.rows(); ++i) {
      if (!(all_weights[i] > 0.0)) continue;
      scene.row(next) = points.row(i).head<3>();
      image.row(next) = points.row(i).tail<2>();
      weights[next++] = all_weights[i];
    }
    if (count < 4 || !scene.allFinite() || !image.allFinite() || !weights.allFinite()) return false;
    const double total = weights.sum();
    mean = scene.transpose() * weights / total;
    scene.rowwise() -= mean.transpose();
    const Eigen::Matrix3d covariance = scene.transpose() * weights.asDiagonal() * scene / total;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    axes = solver.eigenvectors().rowwise().reverse();
    if (axes.determinant() < 0.0) axes.col(2) *= -1.0;
    spread = solver.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
    scene = (scene * axes).eval();
    return spread[0] > 0.0;
  }

  /// A pose of the turned points as one of the scene's.
  AbsolutePose::Parameters InScene(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) const {
    const Eigen::Matrix3d turned = rotation * axes.transpose();
    return PoseOf(turned, translation - turned * mean);
  }
};

/// Solves for the `columns` of [R | t] that the points see: all four, or without the third on a plane.
bool LinearPose(const Resection& data, bool planar, AbsolutePose::Parameters* out) {
  const int unknowns = planar ? 9 : 12;
  const double scale = data.spread[0];
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd row_u(unknowns), row_v(unknowns);
  for (Eigen::Index i = 0; i < data.scene.rows(); ++i) {
    Eigen::VectorXd x(unknowns / 3);
    const Eigen::Vector3d s = data.scene.row(i).transpose() / scale;
    if (planar) {
      x << s[0], s[1], 1.0;
    } else {
      x << s, 1.0;
    }
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(x.size());
    row_u << x, none, -data.image(i, 0) * x;
    row_v << none, x, -data.image(i, 1) * x;
    normal += data.weights[i] * (row_u * row_u.transpose() + row_v * row_v.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(normal);
  const Eigen::VectorXd h = solver.eigenvectors().col(0);
  const auto column = [&](int j) { return Eigen::Vector3d(h[j], h[unknowns / 3 + j], h[2 * unknowns / 3 + j]); };
  Eigen::Matrix3d m;
  Eigen::Vector3d t = column(planar ? 2 : 3);
  const double sign = t[2] < 0.0 ? -1.0 : 1.0;  // The mean of the points is before the camera.
  m.col(0) = sign * column(0);
  m.col(1) = sign * column(1);
  m.col(2) = planar ? Eigen::Vector3d(m.col(0).cross(m.col(1)) / std::sqrt(m.col(0).norm() * m.col(1).norm()))
                    : Eigen::Vector3d(sign * column(2));
  double factor = 0.0;
  const Eigen::Matrix3d rotation = NearestRotation(m, &factor);
  if (!(factor > 0.0) || !std::isfinite(factor)) return false;
  *out = data.InScene(rotation, sign * t * (scale / factor));
  return out->allFinite();
}

/// Σ weight ρ(r²) over the points, its gradient and Gauss-Newton matrix by a rotation and a translation of the camera.
struct PoseEquations {
  double cost = 0.0;
  Matrix6 normal = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();

  PoseEquations(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                const AbsolutePose::Parameters& pose, bool linearize) {
    const Eigen::Matrix3d rotation = RotationOf(pose);
    const Eigen::Vector3d translation = TranslationOf(pose);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      if (!(weights[i] > 0.0)) continue;
      const Eigen::Vector3d turned = rotation * points.row(i).head<3>().transpose(), x = turned + translation;
      const double square = x[2] > 0.0 ? (x.head<2>() / x[2] - points.row(i).tail<2>().transpose()).squaredNorm()
                                       : std::numeric_limits<double>::infinity();
      cost += weights[i] * loss.Value(square);
      if (!linearize || !(x[2] > 0.0)) continue;
      const double inverse = 1.0 / x[2], u = x[0] * inverse, v = x[1] * inverse;
      Eigen::Matrix<double, 2, 3> by_point;
      by_point << inverse, 0.0, -u * inverse, 0.0, inverse, -v * inverse;
      Eigen::Matrix<double, 2, 6> jacobian;
      jacobian << -by_point * CrossMatrix(turned), by_point;
      const Eigen::Vector2d residual = Eigen::Vector2d(u, v) - points.row(i).tail<2>().transpose();
      const double weight = weights[i] * loss.Weight(square);
      normal += weight * jacobian.transpose() * jacobian;
      gradient += weight * jacobian.transpose() * residual;
    }
  }
};

struct PoseProblem {
  static constexpr int kFreedom = 6;
  const PointMatrix& points;
  const Eigen::VectorXd& weights;
  const RobustLoss& loss;

  double Cost(const AbsolutePose::Parameters& pose) const {
    return PoseEquations(points, weights, loss, pose, false).cost;
  }
  void Linearize(const AbsolutePose::Parameters& pose, Matrix6* normal, Vector6* gradient) const {
    const PoseEquations equations(points, weights, loss, pose, true);
    *normal = equations.normal;
    *gradient = equations.gradient;
  }
  static Vector6 Solve(const Matrix6& damped, const Vector6& right) { return damped.ldlt().solve(right); }
  static AbsolutePose::Parameters Retract(const AbsolutePose::Parameters& pose, const Vector6& step) {
    return PoseOf(ExpRotation(step.head<3>()).toRotationMatrix() * RotationOf(pose),
                  TranslationOf(pose) + step.tail<3>());
  }
};

/// True when the pose moved.
bool MinimizePose(const PointMatrix& points, const Eigen::VectorXd& weights, const RobustLoss& loss,
                  AbsolutePose::Parameters* pose) {
  PoseProblem problem{points, weights, loss};
  return Minimize(problem, {}, pose).moved && pose->allFinite();
}

Eigen::VectorXd SquaredResiduals(const PointMatrix& points, const AbsolutePose::Parameters& pose) {
  return RowResiduals<AbsolutePose>(points, pose).cwiseAbs2();
}

/// The pose that shows the plane the same from afar. False where it is no plane: where its relief, seen from the side,
/// would be more than `threshold`.
bool Mirrored(const Resection& plane, double threshold, const AbsolutePose::Parameters& pose,
              AbsolutePose::Parameters* out) {
  const Eigen::Matrix3d rotation = RotationOf(pose);
  const Eigen::Vector3d centre = rotation * plane.mean + TranslationOf(pose);
  if (!(plane.spread[2] <= threshold * centre[2])) return false;
  const auto mirror = [](const Eigen::Vector3d& normal) {
    return Eigen::Matrix3d(Eigen::Matrix3d::Identity() - 2.0 * normal * normal.transpose());
  };
  const Eigen::Matrix3d turned = mirror(centre.normalized()) * rotation * mirror(plane.axes.col(2));
  *out = PoseOf(turned, centre - turned * plane.mean);
  return true;
}

/// log of how much likelier `a` is than `b` by the points that are within the threshold of either, of unknown noise.
double LogOdds(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double threshold) {
  constexpr int kUnknowns = 6;
  const double most = threshold * threshold;
  const auto near = a.array() <= most || b.array() <= most;
  const double sum_a = near.select(a.cwiseMin(most), 0.0).sum(), sum_b = near.select(b.cwiseMin(most), 0.0).sum();
  const double freedom = 2.0 * static_cast<double>(near.count()) - kUnknowns;
  return 0.5 * freedom * std::log(sum_b / sum_a);
}

}  // namespace

bool AbsolutePose::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  constexpr double kLine = 1e-6;
  if (points.cols() != kDimension || weights.size() != points.rows()) return false;
  Resection data;
  if (!data.Gather(points, weights) || !(data.spread[1] > kLine * data.spread[0])) return false;
  // Between a plane and a body both are poor starts; the better one is taken.
  double least = std::numeric_limits<double>::infinity();
  Parameters model;
  for (const bool planar : {false, true}) {
    Parameters start;
    if ((!planar && data.scene.rows() < 6) || !LinearPose(data, planar, &start)) continue;
    const double cost = PoseEquations(points, weights, RobustLoss{}, start, false).cost;
    if (!(cost < least)) continue;
    least = cost;
    model = start;
  }
  if (!std::isfinite(least)) return false;
  MinimizePose(points, weights, RobustLoss{}, &model);
  if (!model.allFinite()) return false;
  *out = model;
  return true;
}

bool AbsolutePose::Refine(const PointMatrix& points, double threshold, Parameters* model) {
  if (points.cols() != kDimension || !(threshold > 0.0) || !std::isfinite(threshold) || !model->allFinite())
    return false;
  Parameters refined = *model;
  const RobustLoss loss{LossKind::kTruncated, threshold};
  if (!MinimizePose(points, Eigen::VectorXd::Ones(points.rows()), loss, &refined)) return false;
  *model = refined;
  return true;
}

bool AbsolutePose::OtherMinimum(const PointMatrix& points, double threshold, Parameters* model, Parameters* other,
                                int* fits) {
  constexpr double kSameDegrees = 0.5;
  const Eigen::VectorXd squares = SquaredResiduals(points, *model);
  const Eigen::VectorXd inliers = (squares.array() <= threshold * threshold).cast<double>();
  Resection plane;
  if (!plane.Gather(points, inliers) || !Mirrored(plane, threshold, *model, other)) return false;
  ++*fits;
  MinimizePose(points, inliers, RobustLoss{}, other);
  Refine(points, threshold, other);
  if (RotationAngleDegrees(RotationOf(*model), RotationOf(*other)) < kSameDegrees) return false;
  const double log_odds = LogOdds(squares, SquaredResiduals(points, *other), threshold);
  if (log_odds < 0.0) std::swap(*model, *other);
  return std::abs(log_odds) < std::log(kOddsToTell);
}

Eigen::Matrix<double, 6, 6> ReprojectionInformation(const PointMatrix& points, const Eigen::VectorXd& weights,
                                                    const AbsolutePose::Parameters& pose) {
  return PoseEquations(points, weights, RobustLoss{}, pose, true).normal;
}

}  // namespace diffsac
