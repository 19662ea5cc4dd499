#pragma once

#include <functional>

namespace diffsac {

/// Calls body(i) for i in [0, count) on the threads of LibTorch's operations (torch::set_num_threads), whose operations
/// within a body stay on its thread. The first exception is rethrown when all have ended.
void ParallelParts(int count, const std::function<void(int)>& body);

}  // namespace diffsac
