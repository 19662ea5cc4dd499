#pragma once

#include <cstdint>

namespace diffsac {

/// Linear warm-up to `peak` over `warmup` steps, then a half cosine down to 0 at `total` (the paper: cosine annealing).
double LearningRate(std::int64_t step, std::int64_t warmup, std::int64_t total, double peak);

}  // namespace diffsac
