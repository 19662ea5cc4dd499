#pragma once

#include <torch/types.h>

#include <string>

namespace diffsac::testing {

/// How the device that these tests register is called: `test_device:0`, `test_device:1`.
///
/// It is LibTorch's "PrivateUse1", with memory of its own (device_memory.h), two places, autograd and autocast, and the
/// CPU's kernels, which first fail where tensors of several devices meet (fallback.h).
inline constexpr const char* kOwnDevice = "test_device";
inline constexpr int kOwnDevices = 2;

/// What the tests run on: DIFFSAC_TEST_DEVICE where that is set (cuda, cuda:1, cpu), else test_device:1. Not the first,
/// so that code which means "that device" but says only its type is found.
std::string TestDeviceName();
torch::Device TestDevice();
bool OnOwnDevice();

}  // namespace diffsac::testing
