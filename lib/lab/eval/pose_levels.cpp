#include "lab/eval/pose_levels.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace diffsac {

double ChiSquareBelow(double value, int freedom) {
  const double half = 0.5 * value;
  const bool odd = freedom % 2 != 0;
  double above = odd ? std::erfc(std::sqrt(half)) : std::exp(-half);
  double term = odd ? std::sqrt(half) * std::exp(-half) / std::tgamma(1.5) : half * std::exp(-half);
  for (int k = odd ? 1 : 2; k < freedom; k += 2) {
    above += term;
    term *= value / (k + 2);
  }
  return 1.0 - above;
}

PoseLevels PoseLevelsOf(const Estimate& estimate, const Example& example) {
  PoseLevels levels;
  if (!IsTwoView(example.problem.task) || !example.truth.pose || !estimate.pose_covariance) return levels;
  const auto pose = PoseOfEstimate(estimate.model, estimate.inliers, example.problem);
  if (!pose) return levels;
  const auto level = [](const auto& error, const auto& covariance) {
    return ChiSquareBelow(error.dot(covariance.inverse() * error), static_cast<int>(error.size()));
  };
  const Eigen::MatrixXd& covariance = *estimate.pose_covariance;
  const Eigen::AngleAxisd turn(example.truth.pose->rotation * pose->rotation.transpose());
  levels.rotation = level(Eigen::Vector3d(turn.angle() * turn.axis()), Eigen::Matrix3d(covariance.topLeftCorner(3, 3)));

  const Eigen::Vector3d t = pose->translation.normalized(), truth = example.truth.pose->translation;
  if (!(truth.norm() > 0.0)) return levels;
  // Across t, as long as the angle between the two.
  Eigen::Matrix<double, 3, 2> across;
  across << t.unitOrthogonal(), t.cross(t.unitOrthogonal());
  const Eigen::Vector2d shift = across.transpose() * truth;
  const double angle = std::atan2(shift.norm(), t.dot(truth));
  const Eigen::Vector2d error = angle / std::max(shift.norm(), std::numeric_limits<double>::min()) * shift;
  levels.translation = level(error, Eigen::Matrix2d(across.transpose() * covariance.block<3, 3>(3, 3) * across));
  return levels;
}

}  // namespace diffsac
