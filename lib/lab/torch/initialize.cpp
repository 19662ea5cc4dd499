#include "lab/torch/initialize.h"

#include <torch/torch.h>

#include <cmath>

namespace diffsac {
namespace {

template <class Draw>
void Fill(torch::Tensor& tensor, Draw draw) {
  torch::NoGradGuard no_grad;
  auto values = torch::empty(tensor.sizes(), torch::kFloat);
  float* out = values.data_ptr<float>();
  for (std::int64_t i = 0; i < values.numel(); ++i) out[i] = static_cast<float>(draw());
  tensor.copy_(values);
}

}  // namespace

torch::nn::Linear MakeLinear(const torch::nn::LinearOptions& options, const Rng& rng, LinearStart start,
                             std::int64_t width) {
  torch::nn::Linear layer(options);
  const double bound = 1.0 / std::sqrt(static_cast<double>(options.in_features()));
  const double deviation = 0.25 * std::sqrt(1.0 / static_cast<double>(width));
  Rng weights = rng.Fork("weight"), biases = rng.Fork("bias");
  Fill(layer->weight, [&] {
    if (start == LinearStart::kZero) return 0.0;
    return start == LinearStart::kScaled ? deviation * weights.Normal() : weights.Uniform(-bound, bound);
  });
  if (layer->bias.defined())
    Fill(layer->bias, [&] { return start == LinearStart::kDefault ? biases.Uniform(-bound, bound) : 0.0; });
  return layer;
}

}  // namespace diffsac
