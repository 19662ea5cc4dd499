#include "lab/torch/losses.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "diffsac/core/status.h"

using namespace diffsac;

namespace {

double Value(const torch::Tensor& x) { return x.item<double>(); }

}  // namespace

TEST_CASE("mse is the mean of squares") {
  const auto c0 = torch::tensor({1.0, -1.0, -1.0, 1.0}).view({1, 2, 2});
  const auto prediction = torch::tensor({0.5, -1.0, 1.0, 0.0}).view({1, 2, 2});
  CHECK(Value(DiffusionLoss(DiffusionLossKind::kMse, prediction, c0)) == Approx((0.25 + 0.0 + 4.0 + 1.0) / 4));
}

TEST_CASE("bce is the cross-entropy of the label +1") {
  const auto c0 = torch::tensor({1.0, -1.0});
  const auto logits = torch::tensor({2.0, 0.5});
  const double expected = (std::log1p(std::exp(-2.0)) + std::log1p(std::exp(0.5))) / 2;
  CHECK(Value(DiffusionLoss(DiffusionLossKind::kBce, logits, c0)) == Approx(expected));
}

TEST_CASE("the positive weight counts the label +1 more in sum and norm") {
  const auto c0 = torch::tensor({1.0, -1.0});
  const auto prediction = torch::tensor({0.0, -3.0});
  CHECK(Value(DiffusionLoss(DiffusionLossKind::kMse, prediction, c0, {}, 3.0)) == Approx((3.0 * 1.0 + 4.0) / 4.0));
}

TEST_CASE("masked elements have no value and no gradient, even when not finite") {
  const DiffusionLossKind kind = GENERATE(DiffusionLossKind::kMse, DiffusionLossKind::kBce);
  const auto c0 = torch::tensor({1.0, -1.0, 1.0, -1.0}).view({1, 1, 4});
  const auto mask = torch::tensor({1, 1, 0, 0}).to(torch::kBool).view({1, 1, 4});
  auto prediction = torch::tensor({0.25, 0.5, 0.0, 0.0}).view({1, 1, 4});
  prediction[0][0][2] = std::numeric_limits<float>::quiet_NaN();
  prediction[0][0][3] = std::numeric_limits<float>::infinity();
  prediction.requires_grad_();
  const auto loss = DiffusionLoss(kind, prediction, c0, mask, 2.0);
  const auto alone = DiffusionLoss(kind, prediction.slice(2, 0, 2), c0.slice(2, 0, 2), {}, 2.0);
  CHECK(Value(loss) == Approx(Value(alone)));
  loss.backward();
  CHECK(prediction.grad()[0][0][0].item<float>() != 0.0f);
  CHECK(prediction.grad()[0][0][2].item<float>() == 0.0f);
  CHECK(prediction.grad()[0][0][3].item<float>() == 0.0f);
}

TEST_CASE("a mask over points is broadcast over the copies") {
  const auto c0 = -torch::ones({2, 3, 4});
  auto prediction = -torch::ones({2, 3, 4});
  prediction.select(2, 3).fill_(5.0);
  const auto mask = torch::tensor({1, 1, 1, 0}).to(torch::kBool).view({1, 1, 4});
  CHECK(Value(DiffusionLoss(DiffusionLossKind::kMse, prediction, c0, mask)) == 0.0);
}

TEST_CASE("a batch that is masked altogether has loss 0") {
  const auto c0 = torch::ones({1, 1, 3});
  CHECK(Value(DiffusionLoss(DiffusionLossKind::kMse, c0 * 2, c0, torch::zeros({1, 1, 3}, torch::kBool))) == 0.0);
}

TEST_CASE("16-bit predictions are computed in float32") {
  const auto c0 = torch::ones({4});
  const auto loss = DiffusionLoss(DiffusionLossKind::kMse, torch::zeros({4}, torch::kBFloat16), c0);
  CHECK(loss.scalar_type() == torch::kFloat32);
  CHECK(Value(loss) == 1.0);
}

TEST_CASE("logits become the expected label") {
  const auto x = torch::linspace(-6, 6, 13, torch::kFloat64);
  CHECK(torch::allclose(LogitsToConfidence(x), torch::tanh(x / 2)));
  CHECK(Value(LogitsToConfidence(torch::zeros({1}))) == 0.0);
}

TEST_CASE("bad loss arguments are errors") {
  const auto c0 = torch::ones({2, 3});
  CHECK_THROWS_AS(DiffusionLoss(FromString<DiffusionLossKind>("l1"), c0, c0), Error);
  CHECK_THROWS_AS(DiffusionLoss(DiffusionLossKind::kMse, torch::ones({2, 4}), c0), Error);
  CHECK_THROWS_AS(DiffusionLoss(DiffusionLossKind::kMse, c0, c0, {}, 0.0), Error);
}
