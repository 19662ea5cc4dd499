#include "lab/torch/point_relation.h"

#include <catch2/catch.hpp>

#include "lab/torch/test_networks.h"

namespace diffsac {
namespace {

// Two coordinates, then three columns for each of three hypotheses, of which the first is the agreement.
constexpr int kFirst = 2, kWidth = 11;

FeatureSet TwoInstances(int each) {
  FeatureSet set = RandomFeatures(2 * each + 1, kWidth, Rng(5));
  for (int i = 0; i <= 2 * each; ++i)
    for (int h = 0; h < 3; ++h) set.values(i, kFirst + 3 * h) = 0.0f;
  for (int i = 0; i < each; ++i) set.values(i, kFirst) = 0.9f;
  for (int i = each; i < 2 * each; ++i) set.values(i, kFirst + 3) = 0.5f;
  return set;  // the last point agrees with nothing
}

std::shared_ptr<Denoiser> Network(const char* kind) {
  auto options = SmallOptions(kind);
  options.relation = true;
  auto network = std::make_shared<Denoiser>(options, FeatureColumns(kWidth, kFirst), Rng(1));
  FillWithWave(*network);
  return network;
}

}  // namespace

TEST_CASE("points agree with confident points of their own structure") {
  PointRelation relation;
  const auto batch = BatchOf({TwoInstances(4)});
  auto c_t = torch::full({1, 2, 9}, -1.0f);
  c_t[0][0][1] = 1.0f;  // copy 0: a point of the first structure is confident, copy 1: one of the second
  c_t[0][1][6] = 1.0f;
  const torch::NoGradGuard no_grad;
  const auto outputs = relation.Forward(PointRelation::Agreements(batch.features, kFirst), batch.mask, c_t);
  REQUIRE(outputs.size() == PointRelation::kOutputs);
  const auto sharp = outputs[1];
  for (int i = 0; i < 8; ++i) {
    const float first = sharp[0][0][i].item<float>(), second = sharp[0][1][i].item<float>();
    CHECK((first > 0.95f) == (i < 4));
    CHECK((second > 0.95f) == (i >= 4));
    CHECK(std::min(first, second) < 0.3f);
  }
  CHECK(sharp[0][0][8].item<float>() == 0.0f);
  CHECK(outputs[0][0][0][4].item<float>() > sharp[0][0][4].item<float>());  // the flat one sees more of the others
}

TEST_CASE("a denoiser that relates points is equivariant and does not see padding") {
  for (const char* kind : {"point_transformer", "pooled", "mlp"}) {
    const auto network = Network(kind);
    const torch::NoGradGuard no_grad;
    const auto run = [&](const PointBatch& batch, const torch::Tensor& c_t) {
      return network->Denoise(network->Encode(batch), c_t, torch::full({1, 1}, 42.0f));
    };
    const auto small = TwoInstances(3), large = TwoInstances(6);
    const auto c_t = RandomTensor({1, 2, 7}, Rng(3));
    const auto alone = run(BatchOf({small}), c_t);
    CHECK(alone.std().item<float>() > 1e-4);
    const auto order = Rng(4).Permutation(7);
    auto permuted = small;
    for (int i = 0; i < 7; ++i) permuted.values.row(i) = small.values.row(order[i]);
    const auto index = torch::tensor(std::vector<std::int64_t>(order.begin(), order.end()));
    CHECK(MaxDifference(run(BatchOf({permuted}), c_t.index_select(2, index)), alone.index_select(2, index)) < 1e-4);
    auto padded = torch::full({2, 2, 13}, 7.0f);
    padded.slice(0, 0, 1).slice(2, 0, 7).copy_(c_t);
    CHECK(MaxDifference(run(BatchOf({small, large}), padded).slice(0, 0, 1).slice(2, 0, 7), alone) < 1e-4);
  }
}

TEST_CASE("layers of each point alone relate points through the relation") {
  const auto network = Network("mlp");
  const torch::NoGradGuard no_grad;
  const auto context = network->Encode(BatchOf({TwoInstances(4)}));
  const auto c_t = RandomTensor({1, 1, 9}, Rng(3)), t = torch::full({1, 1}, 5.0f);
  auto other = c_t.clone();
  other[0][0][1] = 4.0f;
  const auto change = (network->Denoise(context, other, t) - network->Denoise(context, c_t, t)).abs();
  CHECK(change[0][0][2].item<float>() > 1e-4f);
  CHECK(change[0][0][8].item<float>() < 1e-6f);  // it agrees with nobody
}

TEST_CASE("a relation without residual features is refused") {
  auto options = SmallOptions("pooled");
  options.relation = true;
  CHECK_THROWS_WITH(Denoiser(options, 6, Rng(1)), Catch::Contains("relation") && Catch::Contains("residual"));
}

}  // namespace diffsac
