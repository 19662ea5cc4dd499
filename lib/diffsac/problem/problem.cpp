#include "diffsac/problem/problem.h"

#include <cstdio>

#include "diffsac/consensus/false_alarms.h"
#include "diffsac/problem/tasks.h"

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

Eigen::VectorXd PointWeights(const Problem& problem) {
  return DispatchDescription(problem.task, [&]<class Description>() -> Eigen::VectorXd {
    if constexpr (requires { Description::PointWeights(problem); }) return Description::PointWeights(problem);
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

std::optional<FocalEstimate> FocalEstimateOf(const FocalPosterior& posterior, const Problem& problem) {
  return DispatchDescription(problem.task, [&]<class Description>() -> std::optional<FocalEstimate> {
    if constexpr (requires { Description::InPixels(posterior, problem); })
      return Description::InPixels(posterior, problem);
    return std::nullopt;
  });
}

double LogFalseAlarmsOf(const Problem& problem, int inliers, double threshold) {
  const double share = DispatchDescription(
      problem.task, [&]<class Description>() { return Description::ChanceShare(problem, threshold); });
  return LogFalseAlarms(static_cast<int>(problem.points.rows()), inliers, MinimalSetSize(problem.task), share);
}

Status CheckProblem(const Problem& problem) { return CheckSpace(SolverSpace(problem), {problem.task}); }

std::string PointDigest(const PointMatrix& points) {
  // FNV-1a (Fowler, Noll, Vo).
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](const void* bytes, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(bytes)[i]) * 0x100000001b3u;
  };
  const std::int64_t columns = points.cols();
  add(&columns, sizeof(columns));
  add(points.data(), sizeof(double) * static_cast<std::size_t>(points.size()));
  char text[9];
  std::snprintf(text, sizeof(text), "%08x", static_cast<unsigned>(hash ^ (hash >> 32)));
  return text;
}

std::string ProblemName(const Example& example) {
  return example.digest.empty() ? example.id : example.id + "@" + example.digest;
}

std::string Dataset::FolderOf(const std::string&) const { return ""; }

}  // namespace diffsac
