#include <catch2/catch.hpp>

#include <filesystem>

#include <unistd.h>

#include "diffsac/core/status.h"
#include "lab/config/yaml.h"
#include "lab/options/options.h"
#include "lab/torch/checkpoint.h"
#include "lab/torch/clnet.h"
#include "lab/torch/ng_ransac.h"
#include "lab/torch/test_networks.h"

namespace diffsac {
namespace {

constexpr int kColumns = 6;

// Small random values in place of the starting ones, so that no output is trivially equal.
void FillRandomly(torch::nn::Module& network) {
  const torch::NoGradGuard no_grad;
  std::uint64_t index = 0;
  for (auto& parameter : network.parameters()) {
    Rng rng = Rng(3).Fork("parameter", ++index);
    const auto width = static_cast<double>(parameter.size(-1));
    for (std::int64_t i = 0; i < parameter.numel(); ++i)
      parameter.data_ptr<float>()[i] = static_cast<float>(rng.Normal() / std::sqrt(width));
  }
}

std::vector<std::shared_ptr<WeightNetwork>> Networks() {
  NgRansacNetworkOptions ng;
  ng.width = 16;
  ng.blocks = 3;
  ClnetNetworkOptions cl;
  cl.width = 16;
  cl.fewest = 4;
  std::vector<std::shared_ptr<WeightNetwork>> networks = {std::make_shared<NgRansacNetwork>(ng, kColumns, Rng(1)),
                                                          std::make_shared<ClnetNetwork>(cl, kColumns, Rng(1))};
  for (auto& network : networks) FillRandomly(*network);
  return networks;
}

torch::Tensor Weigh(WeightNetwork& network, const PointBatch& batch) {
  const torch::NoGradGuard no_grad;
  return network.Weights(batch);
}

}  // namespace

TEST_CASE("permuting the points permutes the weights") {
  for (auto& network : Networks()) {
    const auto set = RandomFeatures(40, kColumns, Rng(2));
    const auto order = Rng(4).Fork("order").Permutation(40);
    auto permuted = set;
    for (int i = 0; i < 40; ++i) permuted.values.row(i) = set.values.row(order[i]);
    const auto index = torch::tensor(std::vector<std::int64_t>(order.begin(), order.end()));
    const auto expected = Weigh(*network, BatchOf({set})).index_select(1, index);
    CHECK(MaxDifference(Weigh(*network, BatchOf({permuted})), expected) < 1e-5);
    CHECK(expected.std().item<float>() > 1e-3);
  }
}

TEST_CASE("weights do not depend on batch mates, padding has none") {
  for (auto& network : Networks()) {
    const auto small = RandomFeatures(7, kColumns, Rng(2)), large = RandomFeatures(33, kColumns, Rng(3));
    const auto together = Weigh(*network, BatchOf({small, large}));
    CHECK(MaxDifference(together[0].slice(0, 0, 7), Weigh(*network, BatchOf({small}))[0]) < 1e-5);
    CHECK(MaxDifference(together[1], Weigh(*network, BatchOf({large}))[0]) < 1e-5);
    CHECK(together[0].slice(0, 7).abs().max().item<float>() == 0.0f);
  }
}

TEST_CASE("sampling weights are a distribution, and a new network's is uniform") {
  auto networks = Networks();
  const auto batch = BatchOf({RandomFeatures(7, kColumns, Rng(2)), RandomFeatures(33, kColumns, Rng(3))});
  CHECK(MaxDifference(Weigh(*networks[0], batch).sum(1), torch::ones({2})) < 1e-5);
  auto fresh = NgRansacNetwork({}, kColumns, Rng(5));
  CHECK(MaxDifference(Weigh(fresh, BatchOf({RandomFeatures(10, kColumns, Rng(6))})), torch::full({1, 10}, 0.1f)) <
        1e-6);
}

TEST_CASE("weights by the sigmoid: the reciprocal is affine in that of the softmax") {
  NgRansacNetworkOptions options;
  options.width = 16;
  options.blocks = 3;
  NgRansacNetwork softmax(options, kColumns, Rng(1));
  options.output = NgRansacOutput::kSigmoid;
  NgRansacNetwork sigmoid(options, kColumns, Rng(1));
  FillRandomly(softmax);
  FillRandomly(sigmoid);
  const auto batch = BatchOf({RandomFeatures(7, kColumns, Rng(2)), RandomFeatures(33, kColumns, Rng(3))});
  const auto p = Weigh(softmax, batch), q = Weigh(sigmoid, batch);
  CHECK(MaxDifference(q.sum(1), torch::ones({2})) < 1e-5);
  CHECK(q[0].slice(0, 7).abs().max().item<float>() == 0.0f);
  // exp x ∝ p and 1/(1 + exp −x) ∝ q: 1/q = a + b/p with a, b > 0.
  const auto u = p[1].reciprocal().to(torch::kDouble), v = q[1].reciprocal().to(torch::kDouble);
  const auto slope = ((u - u.mean()) * (v - v.mean())).sum() / (u - u.mean()).square().sum();
  const auto offset = v.mean() - slope * u.mean();
  CHECK(slope.item<double>() > 0.0);
  CHECK(offset.item<double>() > 0.0);
  CHECK(MaxDifference((offset + slope * u) / v, torch::ones_like(v)) < 1e-3);
}

TEST_CASE("context normalisation: mean 0, variance 1 over real points before scale, shift and ReLU") {
  ContextNorm norm(3);
  auto parameters = norm.named_parameters();
  const torch::NoGradGuard no_grad;
  parameters["shift"].fill_(10.0f);  // above the ReLU
  auto x = RandomTensor({2, 8, 3}, Rng(1)) * 4 + 7;
  const auto mask = torch::arange(8).unsqueeze(0) < torch::tensor({{5}, {8}});
  const auto out = norm.Forward(x, MeanShares(mask, 2, 8, x.options())) - 10;
  const auto real = out[0].slice(0, 0, 5);
  CHECK(MaxDifference(real.mean(0), torch::zeros({3})) < 1e-5);
  CHECK(MaxDifference(real.square().mean(0), torch::ones({3})) < 1e-3);
  x[0].slice(0, 5).fill_(1e4f);  // what stands in the padding must not matter
  CHECK(MaxDifference(norm.Forward(x, MeanShares(mask, 2, 8, x.options()))[0].slice(0, 0, 5), real + 10) < 1e-4);
}

TEST_CASE("nearest points in feature space come nearest first and repeat the farthest where there are too few") {
  const auto z = torch::tensor({{{0.0f}, {1.0f}, {3.0f}, {7.0f}, {99.0f}}});
  const auto mask = torch::tensor({{true, true, true, true, false}});
  const auto nearest = NearestInFeatures(z, mask, 6);
  const auto row = [&](int i) {
    const auto values = nearest[0][i].contiguous();
    return std::vector<std::int64_t>(values.data_ptr<std::int64_t>(), values.data_ptr<std::int64_t>() + 6);
  };
  CHECK(row(0) == std::vector<std::int64_t>{0, 1, 2, 3, 3, 3});
  CHECK(row(3) == std::vector<std::int64_t>{3, 2, 1, 0, 0, 0});
}

TEST_CASE("the consensus graph equals the normalised adjacency written out") {
  const auto z = RandomTensor({1, 9, 4}, Rng(1)).to(torch::kDouble);
  const auto w = RandomTensor({1, 9}, Rng(2)).to(torch::kDouble).abs();
  const auto adjacency = w[0].unsqueeze(1) * w[0].unsqueeze(0) + torch::eye(9, torch::kDouble);
  const auto root = adjacency.sum(1).rsqrt();
  const auto laplacian = root.unsqueeze(1) * adjacency * root.unsqueeze(0);
  CHECK(MaxDifference(ConsensusGraph(z, w)[0], torch::matmul(laplacian, z[0])) < 1e-12);
}

TEST_CASE("the annular convolution equals the edges written out") {
  const int width = 4, annulus = 2, neighbors = 4;
  AnnularConvolution layer(width, neighbors, annulus, Rng(1));
  FillRandomly(layer);
  const torch::NoGradGuard no_grad;
  const auto z = RandomTensor({1, 7, width}, Rng(2));
  const auto mask = torch::ones({1, 7}, torch::kBool);
  const auto shares = MeanShares({}, 1, 7, z.options());
  const auto p = layer.named_parameters();
  const auto nearest = NearestInFeatures(z, mask, neighbors)[0];
  // Kernel m over an edge [z_i, z_i − z_j]: B_m on the difference, and parts of z_i that sum to center − Σ B_m.
  auto sums = torch::zeros({7, neighbors / annulus, width});
  const auto kernels = p["ring.weight"].view({annulus, width, width});
  for (int i = 0; i < 7; ++i)
    for (int r = 0; r < neighbors / annulus; ++r) {
      auto sum = torch::matmul(p["center.weight"] - kernels.sum(0), z[0][i]) + p["center.bias"];
      for (int m = 0; m < annulus; ++m) {
        const auto j = nearest[i][r * annulus + m].item<std::int64_t>();
        sum = sum + torch::matmul(kernels[m], z[0][i] - z[0][j]);
      }
      sums[i][r] = sum;
    }
  ContextNorm ring(2 * width), join(width);
  ring.named_parameters()["gain"].copy_(p["ring_norm.gain"]);
  ring.named_parameters()["shift"].copy_(p["ring_norm.shift"]);
  join.named_parameters()["gain"].copy_(p["join_norm.gain"]);
  join.named_parameters()["shift"].copy_(p["join_norm.shift"]);
  const auto hidden = ring.Forward(sums.view({1, 7, 2 * width}), shares);
  const auto expected = join.Forward(torch::matmul(hidden, p["join.weight"].t()) + p["join.bias"], shares);
  CHECK(MaxDifference(layer.Forward(z, mask, shares), expected) < 1e-4);
}

TEST_CASE("each pruning keeps the better half by its global scores") {
  auto network = std::dynamic_pointer_cast<ClnetNetwork>(Networks()[1]);
  const torch::NoGradGuard no_grad;
  const auto output =
      network->Run(BatchOf({RandomFeatures(41, kColumns, Rng(2)), RandomFeatures(6, kColumns, Rng(3))}));
  REQUIRE(output.stages.size() == 2);
  CHECK(output.stages[1].mask.sum(1)[0].item<int>() == 21);
  CHECK(output.mask.sum(1)[0].item<int>() == 11);
  CHECK(output.mask.sum(1)[1].item<int>() == 4);  // `fewest`
  const auto& first = output.stages[0];
  const auto kept = output.stages[1].index[0];
  auto dropped = torch::ones({41}, torch::kBool);
  dropped.index_fill_(0, kept, false);
  CHECK(first.global[0].index_select(0, kept).min().item<float>() >=
        first.global[0].masked_select(dropped).max().item<float>());
  const auto weights = network->Weights(BatchOf({RandomFeatures(41, kColumns, Rng(2))}));
  CHECK((weights > 0).sum().item<int>() <= 11);
}

TEST_CASE("a checkpoint restores a weight network and refuses another") {
  const auto path =
      (std::filesystem::temp_directory_path() / ("diffsac_weights_" + std::to_string(::getpid()))).string();
  auto networks = Networks();
  for (auto& network : networks) {
    SaveCheckpoint(path, {}, *network, ExponentialMovingAverage(*network, 0.9), nullptr);
    auto fresh = Networks();
    auto& same = network == networks[0] ? fresh[0] : fresh[1];
    auto& other = network == networks[0] ? fresh[1] : fresh[0];
    {
      const torch::NoGradGuard no_grad;
      for (auto& parameter : same->parameters()) parameter.zero_();
    }
    LoadAverage(path, *same);
    const auto batch = BatchOf({RandomFeatures(20, kColumns, Rng(2))});
    CHECK(torch::equal(Weigh(*same, batch), Weigh(*network, batch)));
    CHECK_THROWS_AS(LoadAverage(path, *other), Error);
  }
  std::filesystem::remove(path);
}

TEST_CASE("weight network options that make no network are refused with their place") {
  const auto read = [](const std::string& yaml) {
    return ReadOptions<ClnetNetworkOptions>(ConfigFromYaml(yaml, "x.yaml"));
  };
  CHECK_THROWS_WITH(read("neighbors: [9, 7]"), Catch::Contains("x.yaml") && Catch::Contains("annulus"));
  CHECK_THROWS_WITH(read("neighbors: []"), Catch::Contains("neighbors"));
  CHECK_THROWS_WITH(ReadOptions<NgRansacNetworkOptions>(ConfigFromYaml("block: 3", "x.yaml")),
                    Catch::Contains("blocks"));
}

TEST_CASE("the shipped configurations' networks have DiffSAC's number of parameters") {
  // 50 columns for lines, 8 for two views; DiffSAC's compact network has 409 562 and 406 874.
  for (const auto& [columns, parameters] : {std::pair{50, 409562.0}, {8, 406874.0}}) {
    CHECK(std::abs(CountParameters(NgRansacNetwork({}, columns, Rng(1))) / parameters - 1.0) < 0.015);
    CHECK(std::abs(CountParameters(ClnetNetwork({}, columns, Rng(1))) / parameters - 1.0) < 0.015);
  }
}

}  // namespace diffsac
