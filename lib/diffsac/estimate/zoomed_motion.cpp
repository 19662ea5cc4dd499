#include "diffsac/estimate/zoomed_motion.h"

#include <cmath>

#include "diffsac/geometry/focal_evidence.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/plane_pose.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/consensus_options.h"

namespace diffsac {
namespace {

/// The share of the motion that is along an axis where it may go the other way; how far the other one's direction is
/// from it; steps of the logarithm of the ratio, and how far it goes.
constexpr double kLeastAlong = 0.7, kLeastDegrees = 60.0, kStep = 0.1, kReach = 1.5;

template <class Description>
std::optional<RigidMotion> OtherOf(const NormalizedProblem& solved, const Estimate& estimate) {
  constexpr UnknownFocal kUnknown = Description::kUnknownFocal;
  const Eigen::Vector3d& t = estimate.pose->translation;
  if (kUnknown == UnknownFocal::kBoth || !(std::abs(t.z()) > kLeastAlong)) return std::nullopt;
  const FocalPriors priors = Description::PriorsOf(solved.problem(), ConsensusOptions().focal_log_sigma);
  const RobustLoss loss{LossKind::kTruncated, estimate.inlier_threshold / solved.unit()};
  FocalEvidence evidence(kUnknown, solved.points(), Eigen::VectorXd::Ones(solved.points().rows()), loss, priors);
  FocalParameters best = estimate.model;
  if (!evidence.Select(best) || !evidence.Refine(&best)) return std::nullopt;
  const auto at = [&](const FocalParameters& model) { return LogFocals{std::log(model[9]), std::log(model[10])}; };
  const auto reversed = [&](const FocalParameters& model) -> std::optional<RigidMotion> {
    std::vector<std::uint8_t> inliers = estimate.inliers;
    const auto pose = model.allFinite() ? PoseOfEstimate(ModelParameters(model), inliers, solved) : std::nullopt;
    if (!pose || DirectionAngleDegrees(pose->translation, t) < kLeastDegrees) return std::nullopt;
    const double behind = Description::LeaveOutBehind(model, *pose, solved, loss.scale, &inliers);
    return behind <= kMostBehind ? pose : std::nullopt;
  };
  // Of one unknown length all of the ratio is that one's.
  const double first = kUnknown == UnknownFocal::kSecond ? 0.0 : 0.5;
  const LogFocals start = at(best);
  const double top = evidence.At(start, best).log_posterior;
  double least = -std::log(kClearOdds);
  std::optional<RigidMotion> other;
  for (const double sign : {-1.0, 1.0}) {
    FocalParameters model = best;
    for (double ratio = kStep; ratio <= kReach; ratio += kStep) {
      model = evidence.At({start[0] - sign * first * ratio, start[1] + sign * (1.0 - first) * ratio}, model).model;
      if (!reversed(model)) continue;
      FocalEvidence with_free_lengths = evidence;
      if (!with_free_lengths.Refine(&model)) break;
      const FocalNode node = evidence.At(at(model), model);
      const auto pose = reversed(node.model);
      if (!pose || !(node.log_posterior - top > least)) break;
      other = pose;
      least = node.log_posterior - top;
      break;
    }
  }
  return other;
}

}  // namespace

std::optional<RigidMotion> MotionOfOtherRatio(const NormalizedProblem& solved, const Estimate& estimate) {
  return DispatchDescription(solved.problem().task, [&]<class Description>() -> std::optional<RigidMotion> {
    if constexpr (requires { Description::kUnknownFocal; }) return OtherOf<Description>(solved, estimate);
    return std::nullopt;
  });
}

}  // namespace diffsac
