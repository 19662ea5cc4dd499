#include "diffsac/estimators/pose_covariance.h"

#include "diffsac/problem/tasks.h"

namespace diffsac {

std::optional<Eigen::MatrixXd> PoseCovarianceOf(const SolverSpace& space, const ModelParameters& model,
                                                const std::vector<std::uint8_t>& inliers, const FitConditions& fit) {
  return DispatchDescription(space.problem().task, [&]<class Description>() -> std::optional<Eigen::MatrixXd> {
    if constexpr (requires { Description::PoseCovariance(model, inliers, space, fit); })
      return Description::PoseCovariance(model, inliers, space, fit);
    return std::nullopt;
  });
}

}  // namespace diffsac
