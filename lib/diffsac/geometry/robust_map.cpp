#include "diffsac/geometry/robust_map.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/svd3.h"

namespace diffsac {
namespace {

constexpr int kMostFitted = 500;

/// How far a match is from x2 ~ M x1, in σ of its noise where both points have 1: Mahalanobis. Infinite where M turns
/// it behind the camera.
double MapDistance(const Eigen::Matrix3d& m, const double* p) {
  const Eigen::Vector3d q = m * Eigen::Vector3d(p[0], p[1], 1.0);
  if (!(q[2] > 0.0)) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d y = q.hnormalized(), r = y - Eigen::Vector2d(p[2], p[3]);
  const Eigen::Matrix2d j = (m.topLeftCorner<2, 2>() - y * m.block<1, 2>(2, 0)) / q[2];
  const Eigen::Matrix2d noise = Eigen::Matrix2d::Identity() + j * j.transpose();
  return std::sqrt(r.dot(noise.inverse() * r));
}

}  // namespace

PointMatrix RowsOf(const PointMatrix& points, const std::vector<std::uint8_t>& inliers) {
  std::vector<int> rows;
  for (int i = 0; i < points.rows(); ++i)
    if (inliers[i] != 0) rows.push_back(i);
  return points(rows, Eigen::all);
}

PointMatrix SpreadRows(const PointMatrix& points) {
  if (points.rows() <= kMostFitted) return points;
  PointMatrix chosen(kMostFitted, 4);
  for (int i = 0; i < kMostFitted; ++i) chosen.row(i) = points.row(i * points.rows() / kMostFitted);
  return chosen;
}

double Extent(const PointMatrix& points) {
  return (points.rightCols(2).colwise().maxCoeff() - points.rightCols(2).colwise().minCoeff()).norm();
}

Eigen::VectorXd MapDistances(const Eigen::Matrix3d& m, const PointMatrix& points, double least, double greatest) {
  Eigen::VectorXd distances(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    distances[i] = std::clamp(MapDistance(m, points.data() + 4 * i), least, greatest);
  return distances;
}

double Median(Eigen::VectorXd values) {
  double* middle = values.data() + values.size() / 2;
  std::nth_element(values.data(), middle, values.data() + values.size());
  return *middle;
}

bool FitRotation(const PointMatrix& points, const Eigen::VectorXd& weights, Eigen::Matrix3d* rotation) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d a(points(i, 0), points(i, 1), 1.0), b(points(i, 2), points(i, 3), 1.0);
    sum += weights[i] / (a.norm() * b.norm()) * b * a.transpose();
  }
  const Svd3 svd = ComputeRotationSvd3(sum);
  if (!(svd.values[1] > 1e-12 * svd.values[0])) return false;
  *rotation = svd.u * svd.v.transpose();
  return rotation->allFinite();
}

bool FitHomography(const PointMatrix& points, const Eigen::VectorXd& weights, Eigen::Matrix3d* homography) {
  Matrix3Parameters h;
  if (!Homography::Fit(points, weights, &h)) return false;
  *homography = AsMatrix(h);
  return homography->allFinite();
}

bool FitRobustly(const PointMatrix& all, double least, double greatest, MapFit fit, Eigen::Matrix3d* map) {
  constexpr int kSumRounds = 10, kRounds = 16;
  const PointMatrix points = SpreadRows(all);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(points.rows());
  for (int round = 0; round < kRounds; ++round) {
    if (!fit(points, weights, map)) return round > 0;
    const Eigen::VectorXd distances = MapDistances(*map, points, least, greatest);
    const double middle = Median(distances);
    if (round < kSumRounds) {
      weights = distances.cwiseMax(0.5 * middle).cwiseInverse() * middle;
    } else {
      weights = (1.0 + (distances.array() / (2.0 * middle)).square()).square().inverse();
    }
  }
  return true;
}

}  // namespace diffsac
