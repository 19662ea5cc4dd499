#include "lab/torch/denoiser.h"

#include <catch2/catch.hpp>

#include "lab/torch/reference_transformer.h"
#include "lab/torch/test_networks.h"

namespace diffsac {
namespace {

ReferenceTransformer ReferenceOf(const Denoiser& network, const DenoiserOptions& options) {
  ReferenceTransformer::Weights weights;
  for (const auto& item : network.named_parameters()) {
    const auto flat = item.value().detach().flatten();
    weights[item.key()].assign(flat.data_ptr<float>(), flat.data_ptr<float>() + flat.numel());
  }
  return {weights, options.width, options.heads, options.encoder_layers, options.layers};
}

}  // namespace

// The golden tensor is computed by ReferenceTransformer: plain loops in double precision over the same weights,
// as Point-E has it (interleaved q|k|v, scale d^-1/4 on both q and k, pre-norm blocks, erf GELU, cosine half
// first).
TEST_CASE("point transformer equals an independent computation") {
  for (const int encoder_layers : {0, 2}) {
    auto options = SmallOptions("point_transformer", encoder_layers);
    auto network = std::make_shared<Denoiser>(options, 5, Rng(3));
    FillWithWave(*network);
    const auto set = RandomFeatures(7, 5, Rng(11));
    const auto c_t = RandomTensor({1, 2, 7}, Rng(12));
    const torch::NoGradGuard no_grad;
    const auto out = network->Denoise(network->Encode(BatchOf({set})), c_t, torch::tensor({{13.0f, 80.0f}}));
    const auto reference = ReferenceOf(*network, options);
    const std::vector<double> features(set.values.data(), set.values.data() + set.values.size());
    for (int k = 0; k < 2; ++k) {
      const float* c = c_t.data_ptr<float>() + 7 * k;
      const auto expected = reference.Run(features, {c, c + 7}, k == 0 ? 13.0 : 80.0);
      for (int i = 0; i < 7; ++i) CHECK(out[0][k][i].item<float>() == Approx(expected[i]).margin(2e-4));
    }
  }
}

TEST_CASE("time embedding puts the cosine half first") {
  const auto e = TimestepEmbedding(torch::tensor({2.0f}), 4);
  CHECK(e[0][0].item<float>() == Approx(std::cos(2.0)));
  CHECK(e[0][1].item<float>() == Approx(std::cos(0.02)));
  CHECK(e[0][2].item<float>() == Approx(std::sin(2.0)));
  CHECK(e[0][3].item<float>() == Approx(std::sin(0.02)));
}

// Field-notes §2.1: about 37.7 M in the blocks and 2.1 M in the time MLP at width 512, 12 layers, 8 heads.
TEST_CASE("the paper's size has Point-E's number of parameters") {
  DenoiserOptions options;
  options.kind = DenoiserKind::kPointTransformer;
  options.width = 512;
  options.heads = 8;
  options.encoder_layers = 0;
  options.layers = 12;
  options.inlier_head = false;
  const std::int64_t w = 512;
  const std::int64_t mlp = 8 * w * w + 5 * w, attention = 4 * w * w + 4 * w, norm = 2 * w;
  const std::int64_t expected = 12 * (mlp + attention + 2 * norm) + mlp + 2 * norm + (2 * w) + (2 * w + w) + (w + 1);
  CHECK(CountParameters(Denoiser(options, 2, Rng(1))) == expected);
  CHECK(12 * (mlp + attention + 2 * norm) == Approx(37.8e6).epsilon(0.01));
}

}  // namespace diffsac
