#include "diffsac/problem/problem.h"

#include <algorithm>
#include <cmath>

#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/model_hooks.h"
#include "diffsac/ransac/scores/number_of_false_alarms.h"

namespace diffsac {
namespace {

/// Whether the inliers of a model of two views lie on one line, with no more beside it than chance would give: a line
/// leaves two points' worth of a homography open, and all but three parameters of epipolar geometry.
template <class Description>
bool LieOnLine(const ModelParameters& model, const std::vector<std::uint8_t>& inliers, const Problem& problem) {
  constexpr double kReach = 4.0;  // In root mean square residuals, within which a point is on the line.
  constexpr bool kOfPlane = ResidualDimension<typename Description::Model>() == 2;
  constexpr int kFree = Description::Model::kMinimalSize - (kOfPlane ? 2 : 3);
  const Matrix3Parameters pixel_model = Description::PixelModel(model, problem);
  double squares = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < inliers.size(); ++i) {
    if (inliers[i] == 0) continue;
    squares +=
        std::pow(Description::PixelResidual(pixel_model, problem.points.row(static_cast<Eigen::Index>(i)).data()), 2);
    ++count;
  }
  const double reach = kReach * std::sqrt(squares / std::max(1, count));
  if (count == 0 || !std::isfinite(reach)) return false;
  const auto first = BesideLine(problem.points, 0, inliers, reach),
             second = BesideLine(problem.points, 2, inliers, reach);
  int beside = 0, inliers_beside = 0;
  for (std::size_t i = 0; i < inliers.size(); ++i) {
    // A line in one image is enough to leave a homography open, but may be a plane through a camera for others.
    const bool is_beside = kOfPlane ? first[i] != 0 && second[i] != 0 : first[i] != 0 || second[i] != 0;
    beside += is_beside;
    inliers_beside += is_beside && inliers[i] != 0;
  }
  if (count - inliers_beside <= Description::Model::kMinimalSize) return false;
  return Log10Nfa(beside, inliers_beside, kFree, Description::ChanceShare(problem, reach)) >= 0.0;
}

}  // namespace

double DefaultThreshold(Task task) {
  if (task == Task::kHomography) return 3.0;
  return task == Task::kAbsolutePose ? 4.0 : 1.0;
}

void SetThreshold(double threshold_px, Problem* problem) {
  problem->inlier_threshold = threshold_px;
  problem->threshold_is_default = threshold_px == DefaultThreshold(problem->task);
}

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
  return PoseOfEstimate(model, inliers, NormalizedProblem(problem));
}

std::optional<RigidMotion> PoseOfEstimate(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                                          const NormalizedProblem& space) {
  return DispatchDescription(space.problem().task, [&]<class Description>() -> std::optional<RigidMotion> {
    if constexpr (requires { Description::Pose(model, inliers, space); })
      return Description::Pose(model, inliers, space);
    return std::nullopt;
  });
}

ParallaxTest ParallaxOfEstimate(const ModelParameters& model, const std::vector<std::uint8_t>& inliers,
                                const NormalizedProblem& space) {
  return DispatchDescription(space.problem().task, [&]<class Description>() -> ParallaxTest {
    if constexpr (Description::kTwoView) {
      if (LieOnLine<Description>(model, inliers, space.problem())) return {Degeneracy::kLine};
      return Description::Parallax(model, inliers, space);
    }
    return {};
  });
}

std::optional<FocalEstimate> FocalEstimateOf(const std::array<FocalPosterior, 2>& posteriors, const Problem& problem) {
  return DispatchDescription(problem.task, [&]<class Description>() -> std::optional<FocalEstimate> {
    if constexpr (requires { Description::InPixels(posteriors, problem); })
      return Description::InPixels(posteriors, problem);
    return std::nullopt;
  });
}

double Log10NfaOf(const Problem& problem, int inliers, double threshold) {
  const double share = DispatchDescription(
      problem.task, [&]<class Description>() { return Description::ChanceShare(problem, threshold); });
  // Of clouds the threshold is given, not chosen by the points.
  const auto log = IsOfTwoClouds(problem.task) ? LogChanceModels : Log10Nfa;
  return log(static_cast<int>(problem.points.rows()), inliers, MinimalSetSize(problem.task), share);
}

Status CheckProblem(const Problem& problem) { return CheckSpace(NormalizedProblem(problem), {problem.task}); }

}  // namespace diffsac
