#include "lab/train/expected_loss.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic.h"
#include "lab/data/synthetic_two_view.h"
#include "lab/train/consensus_loss.h"

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

namespace {

std::vector<Example> Examples(Task task) {
  std::vector<Example> examples;
  for (int i = 0; i < 3; ++i) {
    if (IsTwoView(task)) {
      SyntheticTwoViewOptions options;
      options.task = task;
      options.matches.outlier_ratio = {0.3, 0.3};
      options.matches.num_points = 80;
      options.matches.noise_px = 0.05;
      options.general = task == Task::kHomography ? 0.0 : 1.0;
      options.planar = task == Task::kHomography ? 1.0 : 0.0;
      options.mixed = options.forward = 0.0;
      options.baseline = {0.3, 0.6};
      options.depth_ratio = {5.0, 10.0};
      examples.push_back(MakeSyntheticTwoView(options, 5)->Get(i));
    } else {
      SyntheticOptions options;
      options.outlier_ratio = {0.3, 0.3};
      options.num_points = 80;
      examples.push_back(MakeSynthetic(task, options, 5)->Get(i));
    }
  }
  return examples;
}

torch::Tensor TrueWeights(const std::vector<Example>& examples, float outlier) {
  auto weights = torch::zeros({static_cast<std::int64_t>(examples.size()), 90}, torch::kDouble);  // 10 are padding
  for (std::size_t b = 0; b < examples.size(); ++b)
    for (std::size_t i = 0; i < examples[b].truth.inliers.size(); ++i)
      weights[static_cast<std::int64_t>(b)][static_cast<std::int64_t>(i)] =
          examples[b].truth.inliers[i] ? 1.0f : outlier;
  return weights;
}

double Loss(const torch::Tensor& weights, const std::vector<Example>& examples) {
  std::vector<LinearFit> fits;
  for (const auto& example : examples) fits.push_back(MakeLinearFit(example));
  return RegressionLoss(weights, fits).item<double>();
}

}  // namespace

TEST_CASE("adaptive temperature cools clear inliers and leaves doubtful ones and outliers") {
  const auto t =
      AdaptiveTemperature(torch::tensor({{0.0f, 0.5f, 1.0f, 0.0f}}), torch::tensor({{1.0f, 1.0f, 1.0f, 0.0f}}), 0.5);
  CHECK(t[0][0].item<double>() == Approx(std::exp(-2.0)));
  CHECK(t[0][1].item<double>() == Approx(std::exp(-1.0)));
  CHECK(t[0][2].item<double>() == Approx(1.0));
  CHECK(t[0][3].item<double>() == Approx(1.0));
}

TEST_CASE("few inliers weigh as much as many outliers, padding nothing") {
  const auto logits = torch::tensor({{0.5f, -1.0f, -1.0f, -1.0f, 123.0f}});
  const auto inliers = torch::tensor({{1.0f, 0.0f, 0.0f, 0.0f, 0.0f}});
  const auto mask = torch::tensor({{true, true, true, true, false}});
  const double expected = 0.5 * (std::log1p(std::exp(-0.5)) + std::log1p(std::exp(-1.0)));
  CHECK(BalancedCrossEntropy(logits, inliers, torch::ones({1, 5}), mask).item<double>() == Approx(expected));
}

TEST_CASE("the weighted fit recovers every model from its inliers, and outliers spoil it") {
  for (const Task task : {Task::kLine, Task::kPlane, Task::kHomography, Task::kFundamental, Task::kEssential}) {
    CAPTURE(ToString(task));
    const auto examples = Examples(task);
    const double right = Loss(TrueWeights(examples, 0.0f), examples);
    CHECK(right >= 0.0);
    CHECK(right < 0.02);
    CHECK(Loss(TrueWeights(examples, 1.0f), examples) > 5.0 * right);
  }
}

TEST_CASE("the regression loss has the gradient of finite differences") {
  for (const Task task : {Task::kLine, Task::kEssential}) {
    CAPTURE(ToString(task));
    const auto examples = Examples(task);
    std::vector<LinearFit> fits;
    for (const auto& example : examples) fits.push_back(MakeLinearFit(example));
    const auto start = TrueWeights(examples, 0.4f);
    auto weights = start.clone().requires_grad_(true);
    RegressionLoss(weights, fits).backward();
    for (const int i : {0, 7, 33}) {
      auto up = start.clone(), down = start.clone();
      up[1][i] += 1e-4;
      down[1][i] -= 1e-4;
      const double numeric = (Loss(up, examples) - Loss(down, examples)) / 2e-4;
      CHECK(weights.grad()[1][i].item<double>() == Approx(numeric).margin(1e-7).epsilon(1e-3));
    }
    CHECK(weights.grad().isfinite().all().item<bool>());
  }
}

TEST_CASE("weights that determine no model cost nothing and have no gradient") {
  const auto examples = Examples(Task::kFundamental);
  std::vector<LinearFit> fits;
  for (const auto& example : examples) fits.push_back(MakeLinearFit(example));
  for (const double value : {0.0, 1.0}) {
    auto weights = torch::zeros({3, 90}, torch::kDouble);
    weights.slice(1, 0, 5).fill_(value);  // none, or five of the eight that are needed
    weights.requires_grad_(true);
    const auto loss = RegressionLoss(weights, fits);
    CHECK(loss.item<double>() == 0.0);
  }
  auto without = examples;
  for (auto& example : without) example.truth.model.resize(0);
  CHECK(Loss(TrueWeights(without, 0.0f), without) == 0.0);
}

}  // namespace diffsac
