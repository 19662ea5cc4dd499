#include "diffsac/geometry/hyperplane.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

namespace diffsac {
namespace {

/// Differences below this share of the coordinates' size are rounding, not geometry.
constexpr double kRoundingShare = 1e-12;
/// Sine of the smallest angle between the two edges of a triplet that still spans a plane.
constexpr double kMinSine = 1e-9;
/// Smallest gap between the two least variances, relative to the largest, for which the normal is unique.
constexpr double kMinVarianceGap = 1e-12;

template <int D>
using Point = Eigen::Matrix<double, D, 1>;

template <int D>
Eigen::Map<const Point<D>> At(const PointMatrix& points, Eigen::Index row) {
  return Eigen::Map<const Point<D>>(points.data() + row * D);
}

/// Whether a length is more than rounding next to coordinates of size `scale`; false for NaN and infinity.
bool IsLength(double length, double scale) {
  return length > kRoundingShare * scale && length > 0.0 && std::isfinite(length);
}

template <int D>
bool SetModel(const Point<D>& normal, const Point<D>& on_model, typename Hyperplane<D>::Parameters* out) {
  out->template head<D>() = normal;
  (*out)[D] = -normal.dot(on_model);
  return out->allFinite();
}

bool MinimalNormal(const PointMatrix& points, const int* set, Point<2>* normal) {
  const auto p = At<2>(points, set[0]);
  const auto q = At<2>(points, set[1]);
  const Point<2> edge = q - p;
  const double length = edge.norm();
  if (!IsLength(length, std::max(p.cwiseAbs().maxCoeff(), q.cwiseAbs().maxCoeff()))) return false;
  *normal = Point<2>(-edge[1] / length, edge[0] / length);
  return true;
}

bool MinimalNormal(const PointMatrix& points, const int* set, Point<3>* normal) {
  const auto p = At<3>(points, set[0]);
  const Point<3> a = At<3>(points, set[1]) - p;
  const Point<3> b = At<3>(points, set[2]) - p;
  const Point<3> cross = a.cross(b);
  const double length_a = a.norm(), length_b = b.norm(), area = cross.norm();
  const double scale = p.cwiseAbs().maxCoeff();
  if (!IsLength(length_a, scale) || !IsLength(length_b, scale)) return false;
  if (!(area > kMinSine * length_a * length_b) || !std::isfinite(area)) return false;
  *normal = cross / area;
  return true;
}

/// The direction of least variance; false when it is not unique.
bool LeastVariance(const Eigen::Matrix2d& scatter, double scale, Point<2>* normal) {
  const double difference = scatter(0, 0) - scatter(1, 1);
  const double gap = std::hypot(2.0 * scatter(0, 1), difference);
  const double trace = scatter.trace();
  if (!IsLength(std::sqrt(trace), scale) || !(gap > kMinVarianceGap * trace)) return false;
  const double angle = 0.5 * std::atan2(2.0 * scatter(0, 1), difference);
  *normal = Point<2>(-std::sin(angle), std::cos(angle));
  return true;
}

bool LeastVariance(const Eigen::Matrix3d& scatter, double scale, Point<3>* normal) {
  const double trace = scatter.trace();
  if (!IsLength(std::sqrt(trace), scale)) return false;
  // The iterative solver: the closed form loses half the digits of the normal when the least variance is tiny.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter / trace);
  if (solver.info() != Eigen::Success) return false;
  const auto& values = solver.eigenvalues();
  if (!(values[1] - values[0] > kMinVarianceGap * values[2])) return false;
  *normal = solver.eigenvectors().col(0);
  return true;
}

/// The point farthest from `origin`, and its distance.
template <int D>
std::pair<Eigen::Index, double> Farthest(const PointMatrix& points, const Point<D>& origin) {
  std::pair<Eigen::Index, double> best{0, 0.0};
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double distance = (At<D>(points, i) - origin).norm();
    if (distance > best.second) best = {i, distance};
  }
  return best;
}

}  // namespace

template <int D>
int Hyperplane<D>::SolveMinimal(const PointMatrix& points, const int* set, Parameters* out) {
  Point<D> normal;
  if (!MinimalNormal(points, set, &normal)) return 0;
  return SetModel<D>(normal, At<D>(points, set[0]), out) ? 1 : 0;
}

template <int D>
bool Hyperplane<D>::Fit(const PointMatrix& points, const Eigen::VectorXd& weights, Parameters* out) {
  if (points.cols() != D || weights.size() != points.rows()) return false;
  double total = 0.0, scale = 0.0;
  int positive = 0;
  Point<D> centroid = Point<D>::Zero();
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double weight = weights[i];
    if (weight == 0.0) continue;
    if (!(weight > 0.0)) return false;
    ++positive;
    total += weight;
    centroid += weight * At<D>(points, i);
    scale = std::max(scale, At<D>(points, i).cwiseAbs().maxCoeff());
  }
  if (positive < D || !(total > 0.0) || !std::isfinite(total)) return false;
  centroid /= total;
  Eigen::Matrix<double, D, D> scatter = Eigen::Matrix<double, D, D>::Zero();
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (weights[i] == 0.0) continue;
    const Point<D> offset = At<D>(points, i) - centroid;
    scatter += (weights[i] / total) * offset * offset.transpose();
  }
  Point<D> normal;
  if (!scatter.allFinite() || !LeastVariance(scatter, scale, &normal)) return false;
  return SetModel<D>(normal, centroid, out);
}

template <int D>
bool Hyperplane<D>::Determined(const PointMatrix& points) {
  if (points.cols() != D || points.rows() < D || !points.allFinite()) return false;
  const Point<D> origin = At<D>(points, 0);
  const auto [far, extent] = Farthest<D>(points, origin);
  if (!IsLength(extent, points.cwiseAbs().maxCoeff())) return false;
  if constexpr (D == 3) {
    const Point<3> axis = (At<3>(points, far) - origin) / extent;
    double width = 0.0;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      width = std::max(width, axis.cross(At<3>(points, i) - origin).norm());
    return width > kMinSine * extent && IsLength(width, points.cwiseAbs().maxCoeff());
  }
  return true;
}

template <int D>
void Hyperplane<D>::Residuals(const Parameters& model, const double* const* columns, int begin, int end, double* out) {
  // Same operations in the same order as `Residual`, so that counts and masks agree exactly.
  const int count = end - begin;
  if constexpr (D == 2) {
    const double a = model[0], b = model[1], d = model[2];
    const double *x = columns[0] + begin, *y = columns[1] + begin;
    for (int i = 0; i < count; ++i) out[i] = std::abs((d + a * x[i]) + b * y[i]);
  } else {
    const double a = model[0], b = model[1], c = model[2], d = model[3];
    const double *x = columns[0] + begin, *y = columns[1] + begin, *z = columns[2] + begin;
    for (int i = 0; i < count; ++i) out[i] = std::abs(((d + a * x[i]) + b * y[i]) + c * z[i]);
  }
}

template struct Hyperplane<2>;
template struct Hyperplane<3>;

double AngleBetweenDegrees(const ModelParameters& a, const ModelParameters& b) {
  if (a.size() != b.size() || a.size() < 3) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::Index size = a.size() - 1;
  const double norm_a = a.head(size).norm(), norm_b = b.head(size).norm();
  if (!(norm_a > 0.0) || !(norm_b > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd unit_a = a.head(size) / norm_a;
  Eigen::VectorXd unit_b = b.head(size) / norm_b;
  if (unit_a.dot(unit_b) < 0.0) unit_b = -unit_b;
  // Kahan's form: exact for small angles, where the arc cosine has lost its digits.
  const double radians = 2.0 * std::atan2((unit_a - unit_b).norm(), (unit_a + unit_b).norm());
  return radians * (180.0 / 3.14159265358979323846);
}

}  // namespace diffsac
