#pragma once

#include <string>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac::testing {

/// One to eight random changes of one of the seeds: bits, bytes, numbers in text and in memory, pieces that go, come
/// twice or come from another seed, a cut end. Without seeds, and now and then with them, random bytes.
std::string MutatedInput(const std::vector<std::string>& seeds, Rng rng);

}  // namespace diffsac::testing
