#include "lab/registration/register_scans.h"

#include <omp.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/pipelines/registration/Registration.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <utility>

#include "diffsac/geometry/motion_errors.h"
#include "lab/images/image_features.h"

namespace diffsac {
namespace {

namespace registration = open3d::pipelines::registration;

Matches3D3D MatchesOf(const Scan& first, const Scan& second) {
  const std::vector<DescriptorMatch> found = MatchMutually(first.descriptors, second.descriptors);
  const auto count = static_cast<Eigen::Index>(found.size());
  PointMatrix points1(count, 3), points2(count, 3);
  Eigen::VectorXd ratios(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    points1.row(i) = first.cloud->points_[found[i].first];
    points2.row(i) = second.cloud->points_[found[i].second];
    ratios[i] = found[i].ratio;
  }
  return {std::move(points1), std::move(points2), std::move(ratios)};
}

double HoldOf(const open3d::geometry::PointCloud& second, const std::vector<Eigen::Vector2i>& pairs) {
  if (pairs.empty()) return 0.0;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector2i& pair : pairs) middle += second.points_[pair[1]] / pairs.size();
  double squared = 0.0;
  for (const Eigen::Vector2i& pair : pairs) squared += (second.points_[pair[1]] - middle).squaredNorm() / pairs.size();
  Eigen::Matrix<double, 6, 6> changes = Eigen::Matrix<double, 6, 6>::Zero();
  for (const Eigen::Vector2i& pair : pairs) {
    const Eigen::Vector3d &normal = second.normals_[pair[1]], arm = second.points_[pair[1]] - middle;
    Eigen::Matrix<double, 6, 1> change;
    change << arm.cross(normal) / std::sqrt(squared), normal;
    changes += change * change.transpose() / pairs.size();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(changes, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

void Refine(const Scan& first, const Scan& second, double reach, Registration* result) {
  // Open3D's threads add in the order in which they end; one adds in order.
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const Eigen::Matrix4d start = TransformOf(*result->estimate.pose);
  auto best = registration::EvaluateRegistration(*first.cloud, *second.cloud, reach, start);
  result->overlap_before = best.fitness_;
  const auto refined = registration::RegistrationICP(*first.cloud, *second.cloud, reach, start,
                                                     registration::TransformationEstimationPointToPlane());
  if (refined.fitness_ >= best.fitness_ && refined.transformation_.allFinite()) best = refined;
  result->overlap1 = best.fitness_;
  result->rmse = best.inlier_rmse_;
  result->hold = HoldOf(*second.cloud, best.correspondence_set_);
  const Eigen::Matrix4d& moved = best.transformation_;
  result->overlap2 =
      registration::EvaluateRegistration(*second.cloud, *first.cloud, reach, moved.inverse().eval()).fitness_;
  omp_set_num_threads(threads);
  result->motion.rotation = moved.topLeftCorner<3, 3>();
  result->motion.translation = moved.topRightCorner<3, 1>() + second.middle - result->motion.rotation * first.middle;
}

}  // namespace

Registration RegisterScans(const Scan& first, const Scan& second, const RegistrationOptions& options) {
  Registration result;
  static_cast<MatchedMotion&>(result) = EstimateMatched(Task::kRigid, MatchesOf(first, second), options);
  if (result.estimate.ok()) Refine(first, second, options.max_residual.value(), &result);
  return result;
}

std::optional<Eigen::Matrix<double, 6, 6>> Information(const Registration& registration,
                                                       const Eigen::Vector3d& first_middle) {
  const std::optional<Eigen::MatrixXd>& covariance = registration.estimate.pose_covariance;
  if (!covariance) return std::nullopt;
  // An error e of g2o's, (translation, half a turn) in the first frame, turns by ω = 2 R e₂ and moves t by R e₁; the
  // covariance is of the motion of the points about the middle.
  const Eigen::Matrix3d& R = registration.motion.rotation;
  Eigen::Matrix<double, 6, 6> of_error;
  of_error << Eigen::Matrix3d::Zero(), 2.0 * R, R, Eigen::Matrix3d::Zero();
  of_error = ErrorsFromOrigin(-R * first_middle, 6) * of_error;
  const Eigen::LDLT<Eigen::MatrixXd> factors(*covariance);
  if (!factors.isPositive()) return std::nullopt;
  const Eigen::Matrix<double, 6, 6> information = of_error.transpose() * factors.solve(of_error);
  if (!information.allFinite()) return std::nullopt;
  return 0.5 * (information + information.transpose());
}

}  // namespace diffsac
