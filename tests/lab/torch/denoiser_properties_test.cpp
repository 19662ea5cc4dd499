#include <catch2/catch.hpp>

#include "lab/config/yaml.h"
#include "lab/options/options.h"
#include "lab/torch/test_networks.h"

namespace diffsac {
namespace {

constexpr const char* kKinds[] = {"point_transformer", "pooled", "mlp", "dgcnn"};

torch::Tensor Run(Denoiser& network, const PointBatch& batch, const torch::Tensor& c_t) {
  const torch::NoGradGuard no_grad;
  return network.Denoise(network.Encode(batch), c_t, torch::full({1, 1}, 42.0f));
}

}  // namespace

TEST_CASE("a new network predicts zero everywhere") {
  for (const char* kind : kKinds) {
    auto network = std::make_shared<Denoiser>(SmallOptions(kind), 6, Rng(1));
    const auto batch = BatchOf({RandomFeatures(9, 6, Rng(2))});
    CHECK(Run(*network, batch, RandomTensor({1, 3, 9}, Rng(3))).abs().max().item<float>() == 0.0f);
    CHECK(network->Encode(batch).inlier_logits.abs().max().item<float>() == 0.0f);
  }
}

TEST_CASE("permuting the points permutes the output") {
  for (const char* kind : kKinds) {
    for (const int encoder_layers : {0, 2}) {
      auto network = std::make_shared<Denoiser>(SmallOptions(kind, encoder_layers), 6, Rng(1));
      FillWithWave(*network);
      auto set = RandomFeatures(11, 6, Rng(2));
      const auto c_t = RandomTensor({1, 2, 11}, Rng(3));
      const auto order = Rng(4).Fork("order").Permutation(11);
      auto permuted = set;
      for (int i = 0; i < 11; ++i) permuted.values.row(i) = set.values.row(order[i]);
      const auto index = torch::tensor(std::vector<std::int64_t>(order.begin(), order.end()));
      const auto expected = Run(*network, BatchOf({set}), c_t).index_select(2, index);
      CHECK(MaxDifference(Run(*network, BatchOf({permuted}), c_t.index_select(2, index)), expected) < 1e-4);
      CHECK(expected.std().item<float>() > 1e-4);
    }
  }
}

TEST_CASE("a problem's output does not depend on its batch mates or on padding") {
  for (const char* kind : kKinds) {
    auto network = std::make_shared<Denoiser>(SmallOptions(kind), 6, Rng(1));
    FillWithWave(*network);
    const auto small = RandomFeatures(5, 6, Rng(2)), large = RandomFeatures(12, 6, Rng(3));
    const auto c_t = RandomTensor({1, 2, 5}, Rng(5));
    const auto alone = Run(*network, BatchOf({small}), c_t);
    const torch::NoGradGuard no_grad;
    auto padded = torch::full({2, 2, 12}, 7.0f);  // what stands in the padding must not matter
    padded.slice(0, 0, 1).slice(2, 0, 5).copy_(c_t);
    const auto batch = BatchOf({small, large});
    const auto context = network->Encode(batch);
    const auto together = network->Denoise(context, padded, torch::full({1, 1}, 42.0f));
    CHECK(MaxDifference(together.slice(0, 0, 1).slice(2, 0, 5), alone) < 1e-4);
    CHECK(MaxDifference(context.inlier_logits[0].slice(0, 0, 5), network->Encode(BatchOf({small})).inlier_logits[0]) <
          1e-4);
  }
}

TEST_CASE("the layers of each point alone do not see the others, all other kinds do") {
  for (const char* kind : kKinds) {
    auto network = std::make_shared<Denoiser>(SmallOptions(kind), 6, Rng(1));
    FillWithWave(*network);
    auto set = RandomFeatures(9, 6, Rng(2));
    const auto c_t = RandomTensor({1, 2, 9}, Rng(3));
    const auto before = Run(*network, BatchOf({set}), c_t);
    set.values.row(8).array() += 1.0f;
    const auto after = Run(*network, BatchOf({set}), c_t);
    const double others = MaxDifference(before.slice(2, 0, 8), after.slice(2, 0, 8));
    if (std::string(kind) == "mlp") {
      CHECK(others == 0.0);
    } else {
      CHECK(others > 1e-5);
    }
  }
}

TEST_CASE("weights depend on the seed alone") {
  torch::manual_seed(1);
  auto a = std::make_shared<Denoiser>(SmallOptions("pooled"), 6, Rng(7));
  torch::manual_seed(2);
  auto b = std::make_shared<Denoiser>(SmallOptions("pooled"), 6, Rng(7));
  auto c = std::make_shared<Denoiser>(SmallOptions("pooled"), 6, Rng(8));
  CHECK(torch::equal(a->parameters()[0], b->parameters()[0]));
  CHECK_FALSE(torch::equal(a->parameters()[0], c->parameters()[0]));
}

TEST_CASE("options that make no network are refused with their place") {
  const auto read = [](const std::string& yaml) {
    return ReadOptions<DenoiserOptions>(ConfigFromYaml(yaml, "x.yaml"));
  };
  CHECK_THROWS_WITH(read("width: 63"), Catch::Contains("x.yaml:1") && Catch::Contains("even"));
  CHECK_THROWS_WITH(read("width: 64\nheads: 5"), Catch::Contains("heads"));
  CHECK_THROWS_WITH(read("encoder_layers: 0"), Catch::Contains("inlier_head"));
  CHECK_THROWS_WITH(read("kind: poled"), Catch::Contains("pooled"));
}

}  // namespace diffsac
