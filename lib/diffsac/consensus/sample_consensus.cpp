#include "diffsac/consensus/sample_consensus.h"

namespace diffsac {

bool UsableScales(double inlier_threshold, const ConsensusOptions& options) {
  // Squares of these lengths, and quotients by them, must be ordinary numbers.
  const auto usable = [](double length) { return length >= kLeastScale && length <= kLargestScale; };
  const double scored = options.score_threshold_factor * inlier_threshold;
  return usable(inlier_threshold) && usable(scored) && usable(options.sigma_factor * inlier_threshold) &&
         usable(options.refit_threshold_factor * inlier_threshold) && usable(options.refit_threshold_factor * scored);
}

std::vector<std::vector<int>> FirstSets(const std::vector<int>& sets, int set_size) {
  std::vector<std::vector<int>> first;
  for (auto begin = sets.begin(); sets.end() - begin >= set_size && first.size() < kReportedSets; begin += set_size)
    first.emplace_back(begin, begin + set_size);
  return first;
}

}  // namespace diffsac
