#include "diffsac/data/problem.h"

#include "diffsac/data/tasks.h"

namespace diffsac {

bool HasItsNeeds(const Problem& problem) {
  return DispatchDescription(problem.task, [&]<class Description>() { return Description::Accepts(problem); });
}

PointMatrix ImagePoints(const Problem& problem) {
  return DispatchDescription(problem.task, [&]<class Description>() -> PointMatrix {
    if constexpr (requires { Description::ImagePoints(problem); }) return Description::ImagePoints(problem);
    return {};
  });
}

std::optional<RigidMotion> PoseOfEstimate(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                                          const Problem& problem) {
  return DispatchDescription(problem.task, [&]<class Description>() -> std::optional<RigidMotion> {
    if constexpr (requires { Description::Pose(model, inliers, problem); })
      return Description::Pose(model, inliers, problem);
    return std::nullopt;
  });
}

Status CheckProblem(const Problem& problem) { return CheckSpace(SolverSpace(problem), {problem.task}); }

std::string Dataset::FolderOf(const std::string&) const { return ""; }

}  // namespace diffsac
