#include "diffsac/estimate/robust_estimator.h"

#include <deque>

#include "diffsac/estimate/diagnose.h"
#include "diffsac/estimate/second_search.h"

namespace diffsac {
namespace {

/// Makes an estimate of usable rows one of all rows.
void GiveToAll(const DeduplicatedPoints& rows, Estimate* estimate) {
  rows.Spread(&estimate->inliers);
  rows.Spread(&estimate->assignment);
  rows.Spread(&estimate->inlier_probabilities);
  rows.Spread(&estimate->posteriors);
  for (std::vector<int>& set : estimate->minimal_sets)
    for (int& row : set) row = rows.RowOf(row);
  estimate->num_nonfinite = rows.left_out();
  estimate->num_duplicates = rows.repeated();
}

}  // namespace

void AddCost(const EstimationStats& other, EstimationStats* report) {
  report->hypotheses += other.hypotheses;
  report->iterations += other.iterations;
  report->ms_features += other.ms_features;
  report->ms_network += other.ms_network;
  report->ms_consensus += other.ms_consensus;
  report->ms_total += other.ms_total;
}

Estimate RobustEstimator::Run(const Problem& problem, std::uint64_t seed) const {
  const PreparedProblem prepared(problem, NoiseRangeOf(problem, SearchesAgain()));
  return Finish(prepared, seed, DoRun(prepared.space(), seed));
}

Estimate RobustEstimator::Finish(const PreparedProblem& prepared, std::uint64_t seed, Estimate estimate) const {
  AddSupport(prepared, &estimate);
  const auto search = [&](const NormalizedProblem& space, SearchReason reason) {
    return reason == SearchReason::kScores && without_scores_ ? without_scores_().DoRun(space, seed)
                                                              : DoRun(space, seed);
  };
  if (!SearchesAgain() || !SearchAgain(prepared, search, &estimate)) Diagnose(prepared, &estimate);
  GiveToAll(prepared.rows(), &estimate);
  return estimate;
}

std::vector<Estimate> RobustEstimator::RunBatch(std::span<const Problem* const> problems,
                                                std::span<const std::uint64_t> seeds) const {
  std::deque<PreparedProblem> prepared;
  std::vector<NormalizedProblem> spaces;
  for (const Problem* problem : problems)
    spaces.push_back(prepared.emplace_back(*problem, NoiseRangeOf(*problem, SearchesAgain())).space());
  std::vector<Estimate> estimates = DoRunBatch(spaces, seeds);
  for (std::size_t i = 0; i < estimates.size(); ++i)
    estimates[i] = Finish(prepared[i], seeds[i], std::move(estimates[i]));
  return estimates;
}

std::vector<Estimate> RobustEstimator::DoRunBatch(std::span<const NormalizedProblem> spaces,
                                                  std::span<const std::uint64_t> seeds) const {
  std::vector<Estimate> estimates;
  estimates.reserve(spaces.size());
  for (std::size_t i = 0; i < spaces.size(); ++i) estimates.push_back(DoRun(spaces[i], seeds[i]));
  return estimates;
}

}  // namespace diffsac
