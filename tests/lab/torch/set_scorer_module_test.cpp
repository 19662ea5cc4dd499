#include "lab/torch/set_scorer_module.h"

#include <torch/torch.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

namespace diffsac {
namespace {

constexpr int kCount = 11, kFeatures = 7, kPairs = 3;

SetScorerOptions SmallOptions() {
  SetScorerOptions options;
  options.width = 12;
  options.heads = 3;
  options.layers = 2;
  options.hidden = 10;
  options.pair_width = 5;
  return options;
}

SetScorer::Rows RandomRows(int rows, int cols, Rng rng) {
  SetScorer::Rows values(rows, cols);
  for (Eigen::Index i = 0; i < values.size(); ++i) values.data()[i] = static_cast<float>(rng.Normal());
  return values;
}

torch::Tensor TensorOf(const SetScorer::Rows& rows, torch::IntArrayRef shape) {
  return torch::from_blob(const_cast<float*>(rows.data()), shape).clone();
}

struct OneSet {
  SetScorer::Rows values = RandomRows(kCount, kFeatures, Rng(1)), pairs = RandomRows(kCount * kCount, kPairs, Rng(2));
  std::vector<std::uint8_t> taken = std::vector<std::uint8_t>(kCount, 0);
  OneSet() { taken[2] = taken[7] = 1; }
};

std::shared_ptr<SetScorerModule> MakeModule() {
  auto module = std::make_shared<SetScorerModule>(SmallOptions(), kFeatures, kPairs, Rng(3));
  const torch::NoGradGuard guard;
  for (auto& item : module->named_parameters())  // What begins as 0 or 1 should matter, too.
    item.value().add_(0.1 * torch::sin(torch::arange(item.value().numel()).view(item.value().sizes())));
  module->eval();
  return module;
}

// The set as the first of two, padded by other values.
torch::Tensor PaddedScores(SetScorerModule& module, const OneSet& set) {
  auto values = torch::ones({2, kCount + 4, kFeatures}), pairs = torch::ones({2, kCount + 4, kCount + 4, kPairs});
  auto there = torch::zeros({2, kCount + 4}, torch::kBool), taken = torch::zeros({2, kCount + 4});
  const torch::indexing::Slice own(0, kCount);
  values.index_put_({0, own}, TensorOf(set.values, {kCount, kFeatures}));
  pairs.index_put_({0, own, own}, TensorOf(set.pairs, {kCount, kCount, kPairs}));
  there.index_put_({0, own}, true);
  there.index_put_({1}, true);
  for (int i = 0; i < kCount; ++i) taken[0][i] = static_cast<float>(set.taken[i]);
  const torch::NoGradGuard guard;
  return module.Score(module.Embed(values), module.Bias(pairs), there, taken, 0.0)[0];
}

}  // namespace

TEST_CASE("a scorer says the same in Eigen and in LibTorch, whatever it is padded with") {
  const auto module = MakeModule();
  const OneSet set;
  const torch::Tensor expected = PaddedScores(*module, set);
  const auto scorer = module->Copy();
  const Eigen::VectorXf scores = SetScorer::Set(*scorer, set.values, set.pairs).Score(set.taken);
  for (int i = 0; i < kCount; ++i) CHECK(scores[i] == Approx(expected[i].item<float>()).margin(2e-5));
  std::vector<std::uint8_t> none(kCount, 0);
  CHECK((SetScorer::Set(*scorer, set.values, set.pairs).Score(none) - scores).cwiseAbs().maxCoeff() > 1e-3f);
}

TEST_CASE("scores move with the elements of the set") {
  const auto scorer = MakeModule()->Copy();
  const OneSet set;
  const Eigen::VectorXf before = SetScorer::Set(*scorer, set.values, set.pairs).Score(set.taken);
  std::vector<int> order(kCount);
  std::iota(order.begin(), order.end(), 0);
  std::reverse(order.begin() + 1, order.end());
  OneSet moved;
  for (int i = 0; i < kCount; ++i) {
    moved.values.row(i) = set.values.row(order[i]);
    moved.taken[i] = set.taken[order[i]];
    for (int j = 0; j < kCount; ++j) moved.pairs.row(i * kCount + j) = set.pairs.row(order[i] * kCount + order[j]);
  }
  const Eigen::VectorXf after = SetScorer::Set(*scorer, moved.values, moved.pairs).Score(moved.taken);
  for (int i = 0; i < kCount; ++i) CHECK(after[i] == Approx(before[order[i]]).margin(1e-5));
}

}  // namespace diffsac
