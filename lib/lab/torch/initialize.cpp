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

void InitializeLinear(torch::nn::LinearImpl& layer, LinearStart start, double standard_deviation, Rng rng) {
  const double bound = 1.0 / std::sqrt(static_cast<double>(layer.weight.size(1)));
  Rng weights = rng.Fork("weight");
  Rng biases = rng.Fork("bias");
  switch (start) {
    case LinearStart::kDefault:
      Fill(layer.weight, [&] { return weights.Uniform(-bound, bound); });
      if (layer.bias.defined()) Fill(layer.bias, [&] { return biases.Uniform(-bound, bound); });
      return;
    case LinearStart::kScaled:
      Fill(layer.weight, [&] { return standard_deviation * weights.Normal(); });
      if (layer.bias.defined()) Fill(layer.bias, [] { return 0.0; });
      return;
    case LinearStart::kZero:
      Fill(layer.weight, [] { return 0.0; });
      if (layer.bias.defined()) Fill(layer.bias, [] { return 0.0; });
      return;
  }
}

}  // namespace diffsac
