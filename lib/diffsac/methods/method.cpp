#include "diffsac/methods/method.h"

namespace diffsac {

std::vector<diffsac::Estimate> Method::EstimateBatch(std::span<const Problem* const> problems,
                                                     std::span<const std::uint64_t> seeds) const {
  std::vector<diffsac::Estimate> estimates;
  estimates.reserve(problems.size());
  for (std::size_t i = 0; i < problems.size(); ++i) estimates.push_back(Estimate(*problems[i], seeds[i]));
  return estimates;
}

}  // namespace diffsac
