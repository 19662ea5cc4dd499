#include "diffsac/problem/absolute_pose_task.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "diffsac/geometry/point_spread.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/geometry/some_rows.h"
#include "diffsac/problem/coordinates.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac {
namespace {

/// The best pose in a mirrored scene fits the points near one plane alone: where most points are no inliers, which
/// share of those that fit does so in the scene mirrored at the inliers' plane alone. They are behind a camera that is
/// turned over.
double ShareMirrored(const PointMatrix& points, const AbsolutePose::Parameters& pose, double threshold,
                     const std::vector<std::uint8_t>& inliers) {
  constexpr Eigen::Index kMostPoints = 500;
  std::vector<Eigen::Index> fitting;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (inliers[static_cast<std::size_t>(i)] != 0) fitting.push_back(i);
  if (fitting.empty() || 2 * std::ssize(fitting) > points.rows()) return 0.0;
  const PointSpread plane = SpreadOf(points(fitting, Eigen::seqN(0, 3)));
  const Eigen::Vector3d normal = plane.axes.col(0);
  const auto rows = SomeRows(points.rows(), kMostPoints);
  PointMatrix mirrored = points(rows, Eigen::all);
  mirrored.leftCols(3) -=
      2.0 * ((mirrored.leftCols(3) * normal).array() - plane.centre.dot(normal)).matrix() * normal.transpose();
  AbsolutePose::Parameters turned = pose;
  for (const double reach : {64.0, 16.0, 4.0, 1.0}) AbsolutePose::Refine(mirrored, reach * threshold, &turned);
  const std::vector<std::uint8_t> fits = InlierMask<AbsolutePose>(mirrored, turned, threshold);
  double alone = 0.0, others = 0.0;
  for (Eigen::Index k = 0; k < rows.size(); ++k) {
    const bool inlier = inliers[static_cast<std::size_t>(rows[k])] != 0;
    alone += fits[static_cast<std::size_t>(k)] != 0 && !inlier;
    others += inlier;
  }
  return alone > 0.0 ? alone / (alone + others) : 0.0;
}

}  // namespace

bool AbsolutePoseTask::Accepts(const Problem& problem) {
  if (!problem.cameras) return false;
  const Eigen::Matrix3d& k = problem.cameras->K1;
  return k.allFinite() && k(0, 0) > 0.0 && k(1, 1) > 0.0 && k.determinant() != 0.0;
}

PointMatrix AbsolutePoseTask::Normalize(const Problem& problem, double* unit) {
  const Eigen::Matrix3d& k = problem.cameras->K1;
  const Eigen::Matrix3d inverse = k.inverse();
  *unit = 0.5 * (k(0, 0) + k(1, 1));
  PointMatrix points = problem.points;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d ray = inverse * Eigen::Vector3d(points(i, 3), points(i, 4), 1.0);
    points(i, 3) = ray[0] / ray[2];
    points(i, 4) = ray[1] / ray[2];
  }
  return points;
}

PointMatrix AbsolutePoseTask::FeatureCoordinates(const NormalizedProblem& space) {
  PointMatrix coordinates = space.points();
  coordinates.leftCols(3) = CentredCoordinates(coordinates.leftCols(3));
  return coordinates;
}

double AbsolutePoseTask::LeaveOutBehind(const ModelParameters& model, const RigidMotion& pose,
                                        const NormalizedProblem& space, double threshold,
                                        std::vector<std::uint8_t>* inliers) {
  const PointMatrix& points = space.points();
  const auto fitting = std::count(inliers->begin(), inliers->end(), 1);
  int behind = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d x = pose.rotation * points.row(i).head<3>().transpose() + pose.translation;
    behind += x[2] < 0.0 && (x.hnormalized() - points.row(i).tail<2>().transpose()).norm() <= threshold;
  }
  const auto share = [](double part, double rest) { return part > 0.0 ? part / (part + rest) : 0.0; };
  return std::max(share(behind, static_cast<double>(fitting)), ShareMirrored(points, model, threshold, *inliers));
}

}  // namespace diffsac
