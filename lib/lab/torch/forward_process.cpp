#include "lab/torch/forward_process.h"

#include <torch/torch.h>

#include <vector>

namespace diffsac {

torch::Tensor AddNoise(const NoiseSchedule& schedule, const torch::Tensor& c0, const torch::Tensor& noise,
                       const torch::Tensor& t) {
  TORCH_CHECK(c0.dim() >= 1 && c0.sizes() == noise.sizes(), "AddNoise: noise must have the shape of c0, ", c0.sizes());
  TORCH_CHECK(t.dim() == 1 && t.size(0) == c0.size(0), "AddNoise: t must have one timestep for each of ", c0.size(0));
  std::vector<std::int64_t> shape(c0.dim(), 1);
  shape[0] = c0.size(0);
  const auto alphas_bar = torch::tensor(schedule.alphas_bar(), torch::kFloat64);
  const auto gather = [&](const torch::Tensor& table) {
    return table.to(t.device()).index_select(0, t).to(c0.options()).view(shape);
  };
  return gather(alphas_bar.sqrt()) * c0 + gather((1.0 - alphas_bar).sqrt()) * noise;
}

}  // namespace diffsac
