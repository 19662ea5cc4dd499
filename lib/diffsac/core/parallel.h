#pragma once

#include <cstdint>
#include <functional>

namespace diffsac {

/// Calls `body(i)` for i in [0, count) on up to `threads` threads (0: all cores, never more). Order is not fixed, so a
/// body must depend on i alone. The first exception is rethrown after the others have stopped.
void ParallelFor(std::int64_t count, int threads, const std::function<void(std::int64_t)>& body);

/// The number of usable cores.
int HardwareThreads();

}  // namespace diffsac
