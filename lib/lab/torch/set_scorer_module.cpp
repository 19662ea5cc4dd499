#include "lab/torch/set_scorer_module.h"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "lab/torch/initialize.h"

namespace diffsac {
namespace nn = torch::nn;

namespace {

nn::LayerNorm MakeNorm(int width) { return nn::LayerNorm(nn::LayerNormOptions({width})); }

}  // namespace

SetScorerModule::Layer::Layer(const SetScorerOptions& options, const Rng& rng) {
  const auto linear = [&](const std::string& name, int in, int out) {
    return register_module(name, MakeLinear({in, out}, rng.Fork(name)));
  };
  before_attention = register_module("before_attention", MakeNorm(options.width));
  before_hidden = register_module("before_hidden", MakeNorm(options.width));
  attention = linear("attention", options.width, 3 * options.width);
  output = linear("output", options.width, options.width);
  hidden = linear("hidden", options.width, options.hidden);
  back = linear("back", options.hidden, options.width);
}

SetScorerModule::SetScorerModule(const SetScorerOptions& options, int features, int pairs, const Rng& rng)
    : options_(options), features_(features), pairs_(pairs) {
  const auto linear = [&](const std::string& name, int in, int out) {
    return register_module(name, MakeLinear({in, out}, rng.Fork(name)));
  };
  input_ = linear("input", features, options.width);
  pair_hidden_ = linear("pair_hidden", pairs, options.pair_width);
  pair_output_ = linear("pair_output", options.pair_width, options.heads * options.layers);
  for (int i = 0; i < options.layers; ++i)
    layers_.push_back(
        register_module("layer" + std::to_string(i), std::make_shared<Layer>(options, rng.Fork("layer", i))));
  score_norm_ = register_module("score_norm", MakeNorm(options.width));
  score_hidden_ = linear("score_hidden", options.width, options.width);
  score_ = linear("score", options.width, 1);
  taken_ = register_parameter("taken", torch::zeros({options.width}));
}

std::shared_ptr<const SetScorer> SetScorerModule::Copy() const {
  const auto weights = named_parameters();
  const auto read = [&](const std::string& name, const std::vector<std::int64_t>&, std::span<float> values) {
    const torch::Tensor tensor = weights[name].detach().to(torch::kCPU).contiguous();
    std::copy_n(tensor.data_ptr<float>(), values.size(), values.begin());
  };
  return std::make_shared<SetScorer>(options_, features_, pairs_, read);
}

torch::Tensor SetScorerModule::Bias(const torch::Tensor& pairs) {
  return pair_output_(torch::gelu(pair_hidden_(pairs))).permute({0, 3, 1, 2});
}

torch::Tensor SetScorerModule::Attend(Layer& layer, const torch::Tensor& x, const torch::Tensor& bias,
                                      const torch::Tensor& there) {
  const std::int64_t batch = x.size(0), count = x.size(1), heads = options_.heads, own = options_.width / heads;
  const auto qkv =
      layer.attention(layer.before_attention(x)).view({batch, count, 3, heads, own}).permute({2, 0, 3, 1, 4});
  auto attention = torch::matmul(qkv[0], qkv[1].transpose(-1, -2)) / std::sqrt(static_cast<double>(own)) + bias;
  attention = attention.masked_fill(there.logical_not().view({batch, 1, 1, count}), -1e9).softmax(-1);
  return layer.output(torch::matmul(attention, qkv[2]).transpose(1, 2).reshape({batch, count, options_.width}));
}

torch::Tensor SetScorerModule::Score(const torch::Tensor& embedded, const torch::Tensor& bias,
                                     const torch::Tensor& there, const torch::Tensor& taken, double dropout) {
  auto x = embedded + taken.unsqueeze(-1) * taken_;
  const auto biases = bias.chunk(options_.layers, 1);
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    Layer& layer = *layers_[i];
    x = x + torch::dropout(Attend(layer, x, biases[i], there), dropout, is_training());
    x = x + torch::dropout(layer.back(torch::gelu(layer.hidden(layer.before_hidden(x)))), dropout, is_training());
  }
  return score_(torch::gelu(score_hidden_(score_norm_(x)))).squeeze(-1);
}

}  // namespace diffsac
