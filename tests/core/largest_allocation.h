#pragma once

#include <cstddef>

namespace diffsac {

/// From here on, LargestAllocation counts.
void WatchAllocations();
/// Bytes of the largest single request of C++ memory since then.
std::size_t LargestAllocation();

}  // namespace diffsac
