#include "diffsac/estimators/robust_estimator.h"

#include <algorithm>
#include <cmath>

namespace diffsac {
namespace {

/// What every estimate says, whatever found it.
void Complete(const Problem& problem, Estimate* estimate) {
  if (estimate->status != Status::kOk) return;
  if (std::isnan(estimate->inlier_threshold)) estimate->inlier_threshold = problem.inlier_threshold;
  const bool several = !estimate->structures.empty();
  const auto inliers = several ? std::count(estimate->assignment.begin(), estimate->assignment.end(), 1)
                               : std::count(estimate->inliers.begin(), estimate->inliers.end(), 1);
  estimate->log_false_alarms = estimate->share_behind > kMostBehind
                                   ? std::numeric_limits<double>::infinity()
                                   : LogFalseAlarmsOf(problem, static_cast<int>(inliers), estimate->inlier_threshold);
}

}  // namespace

Estimate RobustEstimator::Run(const Problem& problem, std::uint64_t seed) const {
  Estimate estimate = DoRun(problem, seed);
  Complete(problem, &estimate);
  return estimate;
}

std::vector<Estimate> RobustEstimator::RunBatch(std::span<const Problem* const> problems,
                                                std::span<const std::uint64_t> seeds) const {
  std::vector<Estimate> estimates = DoRunBatch(problems, seeds);
  for (std::size_t i = 0; i < estimates.size(); ++i) Complete(*problems[i], &estimates[i]);
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
