#include "device/test_device.h"

#include <ATen/detail/PrivateUse1HooksInterface.h>
#include <c10/core/DeviceGuard.h>
#include <c10/core/impl/DeviceGuardImplInterface.h>
#include <torch/torch.h>

#include <cstdlib>
#include <cstring>
#include <utility>

#include "device/device_memory.h"

namespace diffsac::testing {
namespace {

constexpr auto kType = c10::DeviceType::PrivateUse1;

thread_local c10::DeviceIndex current = 0;

// All that is asked of the device runs at once, in the thread that asks: one stream, and events that have happened.
struct Guard final : c10::impl::DeviceGuardImplInterface {
  static c10::Stream OnlyStream(c10::Device device) { return c10::Stream(c10::Stream::DEFAULT, device); }

  c10::DeviceType type() const override { return kType; }
  c10::DeviceIndex deviceCount() const noexcept override { return kOwnDevices; }
  c10::Device getDevice() const override { return {kType, current}; }
  void setDevice(c10::Device device) const override {
    TORCH_CHECK(device.index() >= 0 && device.index() < kOwnDevices, "there is no ", device);
    current = device.index();
  }
  void uncheckedSetDevice(c10::Device device) const noexcept override { current = device.index(); }
  c10::Device exchangeDevice(c10::Device device) const override {
    const c10::Device before = getDevice();
    setDevice(device);
    return before;
  }
  c10::Stream getStream(c10::Device device) const override { return OnlyStream(device); }
  c10::Stream getDefaultStream(c10::Device device) const override { return OnlyStream(device); }
  c10::Stream getNewStream(c10::Device device, int) const override { return OnlyStream(device); }
  c10::Stream exchangeStream(c10::Stream stream) const override { return stream; }
  bool queryStream(const c10::Stream&) const override { return true; }
  void synchronizeStream(const c10::Stream&) const override {}
  void synchronizeDevice(c10::DeviceIndex) const override {}
  void record(void**, const c10::Stream&, c10::DeviceIndex, c10::EventFlag) const override {}
  void block(void*, const c10::Stream&) const override {}
  bool queryEvent(void*) const override { return true; }
  void synchronizeEvent(void*) const override {}
};

struct Allocator final : c10::Allocator {
  static void Free(void* device) { DeviceMemory::Instance().Free(device); }

  c10::DataPtr allocate(std::size_t bytes) override {
    void* device = DeviceMemory::Instance().Allocate(bytes);
    return {device, device, &Free, c10::Device(kType, current)};
  }
  c10::DeleterFnPtr raw_deleter() const override { return &Free; }
  void copy_data(void* to, const void* from, std::size_t bytes) const override {
    const auto& memory = DeviceMemory::Instance();
    std::memcpy(memory.Content(to), memory.Content(from), bytes);
  }
};

struct Hooks final : at::PrivateUse1HooksInterface {
  bool isBuilt() const override { return true; }
  bool isAvailable() const override { return true; }
  bool hasPrimaryContext(c10::DeviceIndex) const override { return true; }
  c10::DeviceIndex deviceCount() const override { return kOwnDevices; }
  c10::DeviceIndex getCurrentDevice() const override { return current; }
  void setCurrentDevice(c10::DeviceIndex device) const override { current = device; }
  c10::DeviceIndex exchangeDevice(c10::DeviceIndex device) const override { return std::exchange(current, device); }
  c10::DeviceIndex maybeExchangeDevice(c10::DeviceIndex device) const override { return exchangeDevice(device); }
};

/// Not beside another device that is tested: LibTorch takes one that is registered for the machine's accelerator, and
/// its gradients' streams for CUDA's.
[[maybe_unused]] const bool kRegistered = [] {
  if (!OnOwnDevice()) return false;
  static const Guard guard;
  static Allocator allocator;
  static Hooks hooks;
  static const c10::impl::DeviceGuardImplRegistrar registrar(kType, &guard);
  c10::SetAllocator(kType, &allocator);
  at::RegisterPrivateUse1HooksInterface(&hooks);
  c10::register_privateuse1_backend(kOwnDevice);
  return true;
}();

}  // namespace

std::string TestDeviceName() {
  const char* asked = std::getenv("DIFFSAC_TEST_DEVICE");
  return asked != nullptr && *asked != '\0' ? asked : kOwnDevice + std::string(":1");
}

bool OnOwnDevice() { return TestDeviceName().starts_with(kOwnDevice); }

torch::Device TestDevice() {
  torch::Device device(TestDeviceName());
  if (!device.is_cpu() && !device.has_index()) device.set_index(0);  // as tensors of it say
  return device;
}

}  // namespace diffsac::testing
