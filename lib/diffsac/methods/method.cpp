#include "diffsac/methods/method.h"

#include <algorithm>
#include <cmath>

namespace diffsac {
namespace {

/// What every estimate says, whatever found it.
void Complete(const Problem& problem, Estimate* estimate) {
  if (estimate->status != Status::kOk) return;
  if (std::isnan(estimate->inlier_threshold)) estimate->inlier_threshold = problem.inlier_threshold;
  const bool several = !estimate->structures.empty();
  const auto inliers = several ? std::count(estimate->labels.begin(), estimate->labels.end(), 1)
                               : std::count(estimate->inliers.begin(), estimate->inliers.end(), 1);
  estimate->log_false_alarms = LogFalseAlarmsOf(problem, static_cast<int>(inliers), estimate->inlier_threshold);
}

}  // namespace

diffsac::Estimate Method::Estimate(const Problem& problem, std::uint64_t seed) const {
  diffsac::Estimate estimate = DoEstimate(problem, seed);
  Complete(problem, &estimate);
  return estimate;
}

std::vector<diffsac::Estimate> Method::EstimateBatch(std::span<const Problem* const> problems,
                                                     std::span<const std::uint64_t> seeds) const {
  std::vector<diffsac::Estimate> estimates = DoEstimateBatch(problems, seeds);
  for (std::size_t i = 0; i < estimates.size(); ++i) Complete(*problems[i], &estimates[i]);
  return estimates;
}

std::vector<diffsac::Estimate> Method::DoEstimateBatch(std::span<const Problem* const> problems,
                                                       std::span<const std::uint64_t> seeds) const {
  std::vector<diffsac::Estimate> estimates;
  estimates.reserve(problems.size());
  for (std::size_t i = 0; i < problems.size(); ++i) estimates.push_back(DoEstimate(*problems[i], seeds[i]));
  return estimates;
}

}  // namespace diffsac
