#include "diffsac/estimate/pose_covariance.h"

#include "diffsac/problem/tasks.h"

namespace diffsac {

std::optional<Eigen::MatrixXd> PoseCovarianceOf(const NormalizedProblem& space, const ModelParameters& model,
                                                const RigidMotion& pose, const FitConditions& fit) {
  return DispatchDescription(space.problem().task, [&]<class Description>() -> std::optional<Eigen::MatrixXd> {
    if constexpr (requires { Description::PoseCovariance(model, pose, space, fit); })
      return Description::PoseCovariance(model, pose, space, fit);
    return std::nullopt;
  });
}

double LeaveOutBehind(const NormalizedProblem& space, const ModelParameters& model, const RigidMotion& pose,
                      double threshold, std::vector<std::uint8_t>* inliers) {
  return DispatchDescription(space.problem().task, [&]<class Description>() {
    if constexpr (requires { Description::LeaveOutBehind(model, pose, space, threshold, inliers); })
      return Description::LeaveOutBehind(model, pose, space, threshold, inliers);
    return 0.0;
  });
}

}  // namespace diffsac
