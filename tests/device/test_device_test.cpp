#include "device/test_device.h"

#include <ATen/autocast_mode.h>
#include <sys/wait.h>
#include <torch/torch.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include <csignal>

namespace diffsac {
namespace {

using Catch::Contains;
using testing::OnOwnDevice;
using testing::TestDevice;

torch::Tensor Wave(std::vector<std::int64_t> sizes) {
  std::int64_t count = 1;
  for (const auto size : sizes) count *= size;
  return torch::sin(0.7 * torch::arange(count, torch::kFloat)).view(sizes);
}

torch::Tensor There(const torch::Tensor& here) { return here.to(TestDevice()); }

void CheckEqual(const torch::Tensor& there, const torch::Tensor& here) {
  CHECK(there.device() == TestDevice());
  CHECK(torch::allclose(there.cpu(), here, 1e-5, 1e-6));
}

}  // namespace

TEST_CASE("operations on the device give what the CPU gives") {
  const auto x = Wave({4, 6}), y = Wave({4, 6}) + 0.5, w = Wave({3, 6}), b = Wave({3});
  const auto index = torch::tensor({2, 0, 3});
  CheckEqual(There(x) + There(y), x + y);
  CheckEqual(1.0 - There(x), 1.0 - x);
  CheckEqual(torch::linear(There(x), There(w), There(b)), torch::linear(x, w, b));
  CheckEqual(torch::cat({There(x), There(y)}, 1), torch::cat({x, y}, 1));
  CheckEqual(There(x).t().select(0, 2).slice(0, 1, 3), x.t().select(0, 2).slice(0, 1, 3));
  CheckEqual(There(x).index_select(0, There(index)), x.index_select(0, index));
  CheckEqual(There(x).masked_fill(There(y) > 0.7, -1.0), x.masked_fill(y > 0.7, -1.0));
  CheckEqual(There(x).softmax(-1), x.softmax(-1));
  CheckEqual(std::get<0>(There(x).topk(2)), std::get<0>(x.topk(2)));
  CheckEqual(There(x).to(torch::kBFloat16).to(torch::kFloat), x.to(torch::kBFloat16).to(torch::kFloat));
  CHECK(There(x).sum().item<float>() == Approx(x.sum().item<float>()));
}

TEST_CASE("what is written in place is on the device, also through views") {
  const auto x = Wave({4, 6});
  auto there = There(x), here = x.clone();
  for (auto* tensor : {&there, &here}) {
    tensor->select(1, 2).fill_(3.0);
    tensor->t().narrow(0, 0, 2).mul_(2.0);
    tensor->diagonal().add_(tensor->diagonal());
    tensor->add_(*tensor);
  }
  CheckEqual(there, here);
}

TEST_CASE("gradients on the device are the CPU's") {
  const auto gradient = [](const torch::Device& device) {
    auto w = Wave({3, 6}).to(device).requires_grad_(true);
    const auto x = Wave({4, 6}).to(device);
    (torch::gelu(torch::linear(x, w)).select(0, 1).square().sum() + w.index({0}).norm()).backward();
    return w.grad();
  };
  CheckEqual(gradient(TestDevice()), gradient(torch::kCPU));
}

TEST_CASE("autocast on the device multiplies in 16 bits and normalises in 32") {
  const auto x = There(Wave({4, 6})), w = There(Wave({3, 6}));
  at::autocast::set_autocast_enabled(TestDevice().type(), true);
  at::autocast::set_autocast_dtype(TestDevice().type(), torch::kBFloat16);
  const auto product = torch::linear(x, w), norm = torch::layer_norm(product, {3});
  at::autocast::clear_cache();
  at::autocast::set_autocast_enabled(TestDevice().type(), false);
  CHECK(product.scalar_type() == torch::kBFloat16);
  if (!TestDevice().is_cpu()) CHECK(norm.scalar_type() == torch::kFloat);  // the CPU has another list
}

TEST_CASE("tensors of several devices in one operation are an error") {
  if (TestDevice().is_cpu()) return;
  const auto x = Wave({4, 6}), y = Wave({4, 6}), w = Wave({3, 6}), b = Wave({3});
  const auto index = torch::tensor({2, 0, 3});
  const auto mixed = Contains("same device");
  CHECK_THROWS_WITH(There(x) + y, mixed);
  CHECK_THROWS_WITH(x * There(y), mixed);
  CHECK_THROWS_WITH(There(x).add_(y), mixed);
  CHECK_THROWS_WITH(torch::cat({There(x), y}, 1), mixed);
  CHECK_THROWS_WITH(torch::stack({x, There(y)}), mixed);
  CHECK_THROWS_WITH(torch::linear(There(x), w, There(b)), mixed);
  CHECK_THROWS_WITH(torch::linear(There(x), There(w), b), mixed);
  CHECK_THROWS_WITH(torch::layer_norm(There(x), {6}, There(Wave({6})), Wave({6})), mixed);
  CHECK_THROWS_WITH(torch::where(There(x) > 0, There(x), y), mixed);
  CHECK_THROWS_WITH(There(x).index_select(0, index), mixed);
  CHECK_THROWS_WITH(There(x).gather(0, index.unsqueeze(1)), mixed);
  CHECK_THROWS_WITH(There(x).masked_fill(y > 0, 1.0), mixed);
  CHECK_THROWS_WITH(torch::binary_cross_entropy_with_logits(There(x), y), mixed);
  CHECK_THROWS_WITH(x.lerp_(There(y), 0.5), mixed);
  // As with CUDA: numbers and the indices of index() may come from the CPU.
  CHECK_NOTHROW(There(x) + torch::tensor(2.0f));
  CHECK_NOTHROW(There(x).index({index}));
}

TEST_CASE("tensors of two places of the device are an error") {
  if (!OnOwnDevice()) return;
  const torch::Device other(TestDevice().type(), 0);
  CHECK_THROWS_WITH(There(Wave({4})) + Wave({4}).to(other), Contains("same device"));
  CHECK(torch::equal(There(Wave({4})).to(other).cpu(), Wave({4})));
}

TEST_CASE("a pointer into the device's memory cannot be followed") {
  if (!OnOwnDevice()) return;
  const auto x = There(Wave({4, 6}));
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGSEGV, [](int) { ::_exit(42); });
    const volatile float value = x.data_ptr<float>()[0];
    ::_exit(value == 0.0f ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 42));
}

}  // namespace diffsac
