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
  // Of one unknown length all of the ratio is that one's.
  const double first = kUnknown == UnknownFocal::kSecond ? 0.0 : 0.5;
  double least = -std::log(kClearOdds);
  std::optional<RigidMotion> other;
  for (const double sign : {-1.0, 1.0}) {
    FocalNode node = evidence.At({std::log(best[9]), std::log(best[10])}, best);
    const double top = node.log_posterior;
    for (double ratio = kStep; ratio <= kReach; ratio += kStep) {
      node = evidence.At({std::log(best[9]) - sign * first * ratio, std::log(best[10]) + sign * (1.0 - first) * ratio},
                         node.model);
      if (!node.model.allFinite()) break;
      // Between both motions there may be none that explains the matches.
      if (!(node.log_posterior - top > least)) continue;
      std::vector<std::uint8_t> inliers = estimate.inliers;
      const auto pose = PoseOfEstimate(ModelParameters(node.model), inliers, solved);
      if (!pose || DirectionAngleDegrees(pose->translation, t) < kLeastDegrees) continue;
      if (Description::LeaveOutBehind(node.model, *pose, solved, loss.scale, &inliers) > kMostBehind) continue;
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
