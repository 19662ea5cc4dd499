#include "diffsac/consensus/sample_consensus.h"

namespace diffsac {

std::vector<std::vector<int>> FirstSets(const std::vector<int>& sets, int set_size) {
  std::vector<std::vector<int>> first;
  for (auto begin = sets.begin(); sets.end() - begin >= set_size && first.size() < kReportedSets; begin += set_size)
    first.emplace_back(begin, begin + set_size);
  return first;
}

}  // namespace diffsac
