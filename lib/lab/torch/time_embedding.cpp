#include "lab/torch/time_embedding.h"

#include <torch/torch.h>

#include <cmath>

namespace diffsac {

torch::Tensor TimestepEmbedding(const torch::Tensor& t, std::int64_t width) {
  TORCH_CHECK(width % 2 == 0, "the time embedding's width must be even, got ", width);
  const std::int64_t half = width / 2;
  const auto frequencies = torch::exp(torch::arange(half, t.options().dtype(torch::kFloat)) *
                                      (-std::log(10000.0) / static_cast<double>(half)));
  const auto angles = t.to(torch::kFloat).unsqueeze(-1) * frequencies;
  return torch::cat({angles.cos(), angles.sin()}, -1);
}

}  // namespace diffsac
