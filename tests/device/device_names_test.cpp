#include <torch/torch.h>

#include <catch2/catch.hpp>

#include "core/errors.h"
#include "device/test_device.h"
#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"
#include "lab/config/make_estimator.h"
#include "lab/config/yaml.h"
#include "lab/torch/learned_network.h"

namespace diffsac {
namespace {

using Catch::Contains;

std::string MessageOf(const std::string& name) {
  return ErrorOf([&] { DeviceFromString(name); });
}

}  // namespace

TEST_CASE("devices are found by name and index") {
  CHECK(DeviceFromString("cpu") == torch::Device(torch::kCPU));
  CHECK(DeviceFromString("auto").type() == (torch::cuda::is_available() ? torch::kCUDA : torch::kCPU));
  CHECK(DeviceFromString(testing::TestDeviceName()).type() == testing::TestDevice().type());
  if (!testing::OnOwnDevice()) return;
  CHECK(DeviceFromString("test_device").type() == torch::kPrivateUse1);
  CHECK(DeviceFromString("test_device:1") == torch::Device(torch::kPrivateUse1, 1));
}

TEST_CASE("a device that is no name or is not there is one clear line") {
  for (const std::string name : {"", "tpu", "CPU", "cuda:", "cuda:x", "cuda:-1", "cuda:01", "cuda 0", "cuda:0:1", ":0",
                                 "cpu:0", "meta", "cuda:256", "cuda:99999999999", "test_device:300"}) {
    CAPTURE(name, MessageOf(name));
    CHECK_THAT(MessageOf(name), Contains("device '" + name + "': expected auto, cpu, cuda or cuda:INDEX"));
    CHECK_THAT(MessageOf(name), !Contains("\n"));
  }
  if (testing::OnOwnDevice())
    CHECK(MessageOf("test_device:2") == "device 'test_device:2': there are 2, the first has index 0");
  CHECK(MessageOf("xpu") ==
        "device 'xpu': this LibTorch sees none of this type; expected auto, cpu, cuda or cuda:INDEX");
  if (torch::cuda::is_available()) return;
  for (const std::string name : {"cuda", "cuda:0", "cuda:7"})
    CHECK_THAT(MessageOf(name), Contains("device '" + name + "': this LibTorch sees no CUDA device"));
}

TEST_CASE("rows without a network refuse a device that is not there as well") {
  const auto make = [](const std::string& device) {
    return MakeEstimator(ConfigFromYaml("{type: ransac}"), Task::kLine, {"", device, 1});
  };
  CHECK_THROWS_WITH(make("tpu"), Contains("device 'tpu'"));
  CHECK_NOTHROW(make(testing::TestDeviceName()));
}

}  // namespace diffsac
