#include "lab/torch/process_group.h"

#include <torch/torch.h>

#include <catch2/catch.hpp>

#include <thread>

#include "lab/torch/spawn_ranks.h"

namespace diffsac {
namespace {

using Catch::Contains;
using testing::RunRanks;

constexpr double kTimeoutSeconds = 60.0;

}  // namespace

// Run by the tests below in processes of their own.
TEST_CASE("worker: exchanges", "[.]") {
  const auto group = JoinProcessGroup(kTimeoutSeconds);
  REQUIRE(group);
  const int rank = group->rank(), size = group->size();
  std::vector<double> values = {1.0, rank + 0.5, -1e300 * rank};
  group->Sum(&values);
  CHECK(values[0] == size);
  CHECK(values[1] == size * (size - 1) / 2 + 0.5 * size);
  CHECK(values[2] == -1e300 * (size * (size - 1) / 2));

  // A scalar and a matrix that is not contiguous among them.
  const auto whole = torch::arange(12, torch::kFloat).view({3, 4});
  std::vector<torch::Tensor> tensors = {torch::full({5 << 20}, float(rank)), (whole * (rank + 1)).t(),
                                        torch::tensor(float(rank)), torch::full({5 << 20}, 2.0f)};
  group->Sum(tensors);
  const float sum = static_cast<float>(size * (size - 1) / 2);
  CHECK(tensors[0].eq(sum).all().item<bool>());
  CHECK(tensors[1].eq(whole.t() * (sum + size)).all().item<bool>());
  CHECK(tensors[2].item<float>() == sum);
  CHECK(tensors[3].eq(2.0f * size).all().item<bool>());
}

TEST_CASE("worker: loses its neighbour", "[.]") {
  const bool hangs = std::getenv("DIFFSAC_TEST_HANGS") != nullptr;
  const auto group = JoinProcessGroup(hangs ? 3.0 : kTimeoutSeconds);
  std::vector<double> values = {1.0};
  group->Sum(&values);
  if (group->rank() == 1) {
    if (hangs) std::this_thread::sleep_for(std::chrono::seconds(8));
    ::_exit(7);
  }
  CHECK_THROWS_WITH(group->Sum(&values),
                    Contains("process 0 of 2: another process has ended, or did not answer") && !Contains("\n"));
}

TEST_CASE("worker: waits in vain", "[.]") {
  if (std::getenv("RANK") != std::string("0")) return;
  CHECK_THROWS_WITH(JoinProcessGroup(2.0),
                    Contains("process 0 of 2: cannot join the others at 127.0.0.1:") && !Contains("\n"));
}

TEST_CASE("processes sum") {
  CHECK(RunRanks("worker: exchanges", 2) == std::vector<int>{0, 0});
  CHECK(RunRanks("worker: exchanges", 3) == std::vector<int>{0, 0, 0});
}

TEST_CASE("a process that ends or hangs is noticed") {
  CHECK(RunRanks("worker: loses its neighbour", 2) == std::vector<int>{0, 7});
  CHECK(RunRanks("worker: loses its neighbour", 2, {{"DIFFSAC_TEST_HANGS", "1"}}) == std::vector<int>{0, 7});
}

TEST_CASE("a process that never comes is noticed") {
  CHECK(RunRanks("worker: waits in vain", 2) == std::vector<int>{0, 0});
}

TEST_CASE("without a launcher there is no group") {
  if (std::getenv("RANK") == nullptr && std::getenv("SLURM_STEP_ID") == nullptr)
    CHECK(JoinProcessGroup(1.0) == nullptr);
}

}  // namespace diffsac
