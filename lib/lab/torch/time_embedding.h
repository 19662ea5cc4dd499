#pragma once

#include <torch/types.h>

namespace diffsac {

/// Sinusoidal embedding of diffusion times: [cos(t·f), sin(t·f)] with f_i = 10000^(−i/(width/2)), the cosine half
/// first (Point-E, Nichol et al., 2022). t: any shape, float. Returns [..., width]; width must be even.
torch::Tensor TimestepEmbedding(const torch::Tensor& t, std::int64_t width);

}  // namespace diffsac
