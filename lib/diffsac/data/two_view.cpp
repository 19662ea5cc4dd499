#include "diffsac/data/two_view.h"

#include <cmath>
#include <limits>

#include "diffsac/geometry/epipolar.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {

RigidMotion RelativeMotion(const RigidMotion& camera1, const RigidMotion& camera2) {
  RigidMotion relative;
  relative.rotation = camera2.rotation * camera1.rotation.transpose();
  relative.translation = camera2.translation - relative.rotation * camera1.translation;
  return relative;
}

RigidMotion Inverse(const RigidMotion& motion) {
  return {motion.rotation.transpose(), -(motion.rotation.transpose() * motion.translation)};
}

Eigen::Matrix3d EssentialFromMotion(const RigidMotion& motion) {
  return EssentialFromPose({motion.rotation, motion.translation});
}

void CompleteTruth(const TwoViewProblem& problem, TwoViewTruth* truth) {
  if (!truth->essential && truth->motion) truth->essential = EssentialFromMotion(*truth->motion);
  if (!problem.calibrated) return;
  if (!truth->essential && truth->fundamental)
    truth->essential = EssentialFromFundamental(*truth->fundamental, problem.K1, problem.K2);
  if (!truth->fundamental && truth->essential)
    truth->fundamental = FundamentalFromEssential(*truth->essential, problem.K1, problem.K2);
}

Eigen::VectorXd TruthDistances(const TwoViewProblem& problem, const TwoViewTruth& truth) {
  if (!truth.homography && !truth.fundamental) return {};
  const PointMatrix& points = problem.points;
  const Matrix3Parameters model = AsParameters(truth.homography ? *truth.homography : *truth.fundamental);
  Eigen::VectorXd distances(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double* point = points.data() + i * points.cols();
    const double distance = truth.homography ? TransferError(model, point) : SampsonError(model, point);
    distances[i] = std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity();
  }
  return distances;
}

}  // namespace diffsac
