#include "diffsac/data/two_view.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace diffsac {
namespace {

double TransferDistance(const Eigen::Matrix3d& homography, const Eigen::Vector3d& x1, const Eigen::Vector3d& x2) {
  return ((homography * x1).hnormalized() - x2.head<2>()).norm();
}

// The first-order distance of (x1, x2) from the manifold x2ᵀ F x1 = 0 (Sampson, "Fitting conic sections to very
// scattered data", 1982; Hartley and Zisserman, "Multiple view geometry", 2nd edition, section 11.4.3).
double SampsonDistance(const Eigen::Matrix3d& fundamental, const Eigen::Vector3d& x1, const Eigen::Vector3d& x2) {
  const Eigen::Vector3d line2 = fundamental * x1, line1 = fundamental.transpose() * x2;
  return std::abs(x2.dot(line2)) / std::sqrt(line1.head<2>().squaredNorm() + line2.head<2>().squaredNorm());
}

}  // namespace

RigidMotion RelativeMotion(const RigidMotion& camera1, const RigidMotion& camera2) {
  RigidMotion relative;
  relative.rotation = camera2.rotation * camera1.rotation.transpose();
  relative.translation = camera2.translation - relative.rotation * camera1.translation;
  return relative;
}

RigidMotion Inverse(const RigidMotion& motion) {
  return {motion.rotation.transpose(), -(motion.rotation.transpose() * motion.translation)};
}

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

Eigen::Matrix3d EssentialFromMotion(const RigidMotion& motion) {
  return CrossMatrix(motion.translation) * motion.rotation;
}

void CompleteTruth(const TwoViewProblem& problem, TwoViewTruth* truth) {
  if (!truth->essential && truth->motion) truth->essential = EssentialFromMotion(*truth->motion);
  if (!problem.calibrated) return;
  if (!truth->essential && truth->fundamental)
    truth->essential = problem.K2.transpose() * *truth->fundamental * problem.K1;
  if (!truth->fundamental && truth->essential)
    truth->fundamental = FundamentalFromEssential(*truth->essential, problem.K1, problem.K2);
}

Eigen::VectorXd TruthDistances(const TwoViewProblem& problem, const TwoViewTruth& truth) {
  if (!truth.homography && !truth.fundamental) return {};
  const PointMatrix& points = problem.points;
  Eigen::VectorXd distances(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d x1(points(i, 0), points(i, 1), 1.0), x2(points(i, 2), points(i, 3), 1.0);
    const double distance =
        truth.homography ? TransferDistance(*truth.homography, x1, x2) : SampsonDistance(*truth.fundamental, x1, x2);
    distances[i] = std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity();
  }
  return distances;
}

}  // namespace diffsac
