#include "diffsac/estimators/robust_estimator.h"

#include <algorithm>
#include <cmath>

#include "diffsac/estimators/point_rows.h"
#include "diffsac/estimators/static_overlay.h"

namespace diffsac {
namespace {

/// What every estimate says, whatever found it.
void Complete(const Problem& problem, Estimate* estimate) {
  if (estimate->status != Status::kOk) return;
  if (std::isnan(estimate->inlier_threshold)) estimate->inlier_threshold = problem.inlier_threshold;
  const bool several = !estimate->structures.empty();
  const auto inliers = several ? std::count(estimate->assignment.begin(), estimate->assignment.end(), 1)
                               : std::count(estimate->inliers.begin(), estimate->inliers.end(), 1);
  estimate->log_false_alarms = LogFalseAlarmsOf(problem, static_cast<int>(inliers), estimate->inlier_threshold);
  if (several) return;
  const ParallaxTest test = ParallaxOfEstimate(estimate->model, estimate->inliers, problem);
  estimate->translation = test.translation;
  estimate->turn = test.turn;
  if (IsUndetermined(test.translation)) estimate->pose_covariance.reset();
}

}  // namespace

std::optional<RigidMotion> PoseOfEstimate(const Estimate& estimate, const Problem& problem) {
  if (estimate.status != Status::kOk) return std::nullopt;
  if (estimate.turn) return RigidMotion{*estimate.turn, Eigen::Vector3d::Zero()};
  if (IsUndetermined(estimate.translation)) return std::nullopt;
  return PoseOfEstimate(estimate.model, estimate.inliers, problem);
}

Estimate RobustEstimator::Run(const Problem& problem, std::uint64_t seed) const {
  Estimate estimate = DoRun(problem, seed);
  Complete(problem, &estimate);
  TryMoving(problem, seed, &estimate);
  return estimate;
}

void RobustEstimator::TryMoving(const Problem& problem, std::uint64_t seed, Estimate* estimate) const {
  const std::vector<int> rows = RowsThatMove(problem, *estimate);
  if (rows.empty()) return;
  const SolverSpace whole(problem);
  const PointRows part(whole, rows);
  const Problem& moving = part.space().problem();
  Estimate of_moving = DoRun(moving, seed);
  Complete(moving, &of_moving);
  PreferMoving(rows, std::move(of_moving), estimate);
}

std::vector<Estimate> RobustEstimator::RunBatch(std::span<const Problem* const> problems,
                                                std::span<const std::uint64_t> seeds) const {
  std::vector<Estimate> estimates = DoRunBatch(problems, seeds);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    Complete(*problems[i], &estimates[i]);
    TryMoving(*problems[i], seeds[i], &estimates[i]);
  }
  return estimates;
}

std::vector<Estimate> RobustEstimator::DoRunBatch(std::span<const Problem* const> problems,
                                                  std::span<const std::uint64_t> seeds) const {
  std::vector<Estimate> estimates;
  estimates.reserve(problems.size());
  for (std::size_t i = 0; i < problems.size(); ++i) estimates.push_back(DoRun(*problems[i], seeds[i]));
  return estimates;
}

}  // namespace diffsac
