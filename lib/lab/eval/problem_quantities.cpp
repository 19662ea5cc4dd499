#include "lab/eval/problem_quantities.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "diffsac/geometry/pose.h"
#include "lab/ground_truth/pair_truth.h"

namespace diffsac {
namespace {

constexpr double kUnknownQuantity = std::numeric_limits<double>::quiet_NaN();

double ShareWithin(const Example& example, double within_px) {
  const auto points = static_cast<double>(example.problem.points.rows());
  if (points == 0.0) return kUnknownQuantity;
  if (within_px > 0.0 && example.truth.assignment.empty() && IsTwoView(example.problem.task)) {
    const Eigen::VectorXd distances = TruthDistances(example.problem, example.truth);
    if (distances.size() > 0) return static_cast<double>((distances.array() <= within_px).count()) / points;
  }
  const auto& inliers = example.truth.inliers;
  if (inliers.empty()) return kUnknownQuantity;
  return static_cast<double>(std::count(inliers.begin(), inliers.end(), 1)) / points;
}

double MedianParallax(const Example& example) {
  const GroundTruth& truth = example.truth;
  const Problem& problem = example.problem;
  if (!truth.pose || !problem.cameras) return kUnknownQuantity;
  const Eigen::Matrix3d to_rays1 = truth.pose->rotation * problem.cameras->K1.inverse();
  const Eigen::Matrix3d to_rays2 = problem.cameras->K2.inverse();
  std::vector<double> angles;
  for (std::size_t i = 0; i < truth.inliers.size(); ++i) {
    if (truth.inliers[i] == 0) continue;
    const auto match = problem.points.row(static_cast<Eigen::Index>(i));
    angles.push_back(DirectionAngleDegrees(to_rays1 * Eigen::Vector3d(match[0], match[1], 1.0),
                                           to_rays2 * Eigen::Vector3d(match[2], match[3], 1.0)));
  }
  return Median(std::move(angles));
}

}  // namespace

void RecordQuantities(const Example& example, double within_px, ProblemRecord* record) {
  record->inlier_share = ShareWithin(example, within_px);
  if (!IsTwoView(example.problem.task)) return;
  const GroundTruth& truth = example.truth;
  if (truth.pose) record->true_rotation_deg = RotationAngleDegrees(truth.pose->rotation, Eigen::Matrix3d::Identity());
  if (truth.motion) record->true_baseline = truth.motion->translation.norm();
  record->true_parallax_deg = MedianParallax(example);
}

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
