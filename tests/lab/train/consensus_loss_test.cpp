#include "lab/train/consensus_loss.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>

#include <cmath>

#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic.h"
#include "lab/data/synthetic_two_view.h"

namespace diffsac {
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
