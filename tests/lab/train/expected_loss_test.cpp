#include "lab/train/expected_loss.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <map>

#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic.h"

namespace diffsac {
namespace {

// ℓ of an ordered pair in a made-up problem.
double PairLoss(int a, int b) { return std::sin(1.0 + 3.0 * a + 0.7 * b); }

Example LineExample() {
  SyntheticOptions options;
  options.outlier_ratio = {0.5, 0.5};
  options.num_points = 60;
  return MakeSynthetic(Task::kLine, options, 5)->Get(3);
}

}  // namespace

TEST_CASE("the target distribution falls with the distance from the true model") {
  auto example = LineExample();
  const auto target = TargetDistribution(example, 1.0);
  const auto distances = TruthDistances(example);
  double sum = 0.0;
  for (const float p : target) sum += p;
  CHECK(sum == Approx(1.0).margin(1e-5));
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < target.size(); ++i) nearest = distances[i] < distances[nearest] ? i : nearest;
  for (std::size_t i = 0; i < target.size(); ++i) {
    const double ratio = std::exp(-0.5 * (distances[i] * distances[i] - distances[nearest] * distances[nearest]));
    CHECK(target[i] / target[nearest] == Approx(ratio).margin(1e-5));
  }
  example.truth.model.resize(0);  // only marks: equal shares of the inliers
  double inliers = 0.0;
  for (const auto mark : example.truth.inliers) inliers += mark;
  const auto marked = TargetDistribution(example, 1.0);
  for (std::size_t i = 0; i < marked.size(); ++i) CHECK(marked[i] == Approx(example.truth.inliers[i] / inliers));
  example.truth.inliers.clear();
  CHECK(TargetDistribution(example, 1.0)[0] == Approx(1.0 / 60.0));
}

TEST_CASE("the divergence is that of the definition, 0 at the target, and its descent reaches it") {
  const auto target = torch::tensor({{0.5f, 0.3f, 0.2f, 0.0f}});  // the last is padding
  const auto padded = [](const torch::Tensor& logits) {
    return torch::log_softmax(torch::cat({logits, torch::full({1, 1}, -1e9f)}, 1), 1);
  };
  auto logits = torch::tensor({{0.1f, -0.4f, 0.9f}}).requires_grad_(true);
  const auto p = padded(logits).exp();
  double expected = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double t = target[0][i].item<double>();
    expected += t * std::log(t / p[0][i].item<double>());
  }
  CHECK(TargetDivergence(padded(logits), target).item<double>() == Approx(expected).epsilon(1e-5));
  for (int step = 0; step < 500; ++step) {
    const auto loss = TargetDivergence(padded(logits), target);
    loss.backward();
    const torch::NoGradGuard no_grad;
    logits -= logits.grad();
    logits.mutable_grad().zero_();
  }
  CHECK((padded(logits).exp() - target).abs().max().item<double>() < 1e-4);
}

TEST_CASE("ordered sets are drawn with the probability that is computed for them") {
  const std::vector<float> log_weights = {std::log(0.5f), std::log(0.3f), std::log(0.15f), std::log(0.05f)};
  const int draws = 40000;
  const auto sets = DrawOrderedSets(log_weights, 2, draws, Rng(7));
  REQUIRE(sets.size() == 2 * draws);
  std::map<std::pair<int, int>, int> counts;
  for (int s = 0; s < draws; ++s) ++counts[{sets[2 * s], sets[2 * s + 1]}];
  const auto tensor = torch::tensor(log_weights).unsqueeze(0);
  double total = 0.0;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      if (a == b) {
        CHECK(counts.count({a, b}) == 0);
        continue;
      }
      const auto log_p = OrderedSetLogProbability(tensor, torch::tensor({{{a, b}}}, torch::kLong));
      const double p = std::exp(log_p.item<double>());
      total += p;
      CHECK(counts[{a, b}] / double(draws) == Approx(p).margin(5.0 * std::sqrt(p * (1.0 - p) / draws)));
    }
  CHECK(total == Approx(1.0).epsilon(1e-5));
}

TEST_CASE("the surrogate's gradient is that of the expected loss, by enumeration and by finite differences") {
  const auto logits = torch::tensor({{0.3, -0.2, 0.8, 0.1}}, torch::kDouble);
  const auto expected_loss = [](const torch::Tensor& of) {
    torch::Tensor sum = torch::zeros({}, torch::kDouble);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        if (a != b)
          sum = sum + PairLoss(a, b) *
                          OrderedSetLogProbability(torch::log_softmax(of, 1), torch::tensor({{{a, b}}}, torch::kLong))
                              .exp()
                              .squeeze();
    return sum;
  };
  // Finite differences of the enumerated expectation.
  std::vector<double> numeric(4);
  for (int i = 0; i < 4; ++i) {
    auto up = logits.clone(), down = logits.clone();
    up[0][i] += 1e-5;
    down[0][i] -= 1e-5;
    numeric[i] = (expected_loss(up).item<double>() - expected_loss(down).item<double>()) / 2e-5;
  }
  // The mean of the surrogate's gradient over all pairs of draws, each weighed by its probability: no sampling error.
  auto variable = logits.clone().requires_grad_(true);
  std::vector<std::pair<int, int>> sets;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      if (a != b) sets.emplace_back(a, b);
  torch::Tensor mean = torch::zeros({}, torch::kDouble);
  const auto log_weights = torch::log_softmax(variable, 1);
  for (const auto& [a, b] : sets)
    for (const auto& [c, d] : sets) {
      const auto log_p = OrderedSetLogProbability(log_weights, torch::tensor({{{a, b}, {c, d}}}, torch::kLong));
      const auto losses = torch::tensor({{PairLoss(a, b), PairLoss(c, d)}}, torch::kDouble);
      mean = mean + log_p.detach().sum().exp() * ExpectedLossSurrogate(log_p, losses);
    }
  mean.backward();
  for (int i = 0; i < 4; ++i) CHECK(variable.grad()[0][i].item<double>() == Approx(numeric[i]).margin(1e-7));
}

TEST_CASE("descending the surrogate lowers the expected loss") {
  auto logits = torch::zeros({1, 6}, torch::requires_grad());
  const auto loss_of = [](int a, int b) { return a < 3 && b < 3 ? 0.0f : 1.0f; };  // points 0 to 2 are the inliers
  double first = 0.0, last = 0.0;
  for (int step = 0; step < 300; ++step) {
    const auto log_weights = torch::log_softmax(logits, 1);
    const auto values = log_weights.detach().contiguous();
    const auto sets = DrawOrderedSets({values.data_ptr<float>(), 6}, 2, 8, Rng(1).Fork("step", step));
    auto chosen = torch::empty({1, 8, 2}, torch::kLong);
    auto losses = torch::empty({1, 8});
    for (int k = 0; k < 8; ++k) {
      chosen[0][k][0] = sets[2 * k];
      chosen[0][k][1] = sets[2 * k + 1];
      losses[0][k] = loss_of(sets[2 * k], sets[2 * k + 1]);
    }
    if (step < 5) first += losses.mean().item<double>() / 5;
    if (step >= 280) last += losses.mean().item<double>() / 20;
    ExpectedLossSurrogate(OrderedSetLogProbability(log_weights, chosen), losses).backward();
    const torch::NoGradGuard no_grad;
    logits -= 0.5 * logits.grad();
    logits.mutable_grad().zero_();
  }
  CHECK(first > 0.6);
  CHECK(last < 0.15);
}

}  // namespace diffsac
