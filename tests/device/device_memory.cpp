#include "device/device_memory.h"

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>
#include <stdexcept>

namespace diffsac::testing {
namespace {

constexpr std::size_t kBytes = std::size_t(1) << 32;  // of addresses; memory is taken when it is written to
constexpr std::size_t kLeastBytes = 64;
constexpr int kNan = 0xff;  // in every byte, for floats of any width

char* Reserve(int access) {
  void* address = ::mmap(nullptr, kBytes, access, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (address == MAP_FAILED) throw std::bad_alloc();
  return static_cast<char*>(address);
}

}  // namespace

// Never destroyed: tensors of other static objects may outlive it.
DeviceMemory& DeviceMemory::Instance() {
  static auto* memory = new DeviceMemory;
  return *memory;
}

DeviceMemory::DeviceMemory() : device_(Reserve(PROT_NONE)), content_(Reserve(PROT_READ | PROT_WRITE)) {}

void* DeviceMemory::Allocate(std::size_t bytes) {
  if (bytes == 0) return nullptr;
  const std::lock_guard lock(mutex_);
  const std::size_t size = std::bit_ceil(std::max(bytes, kLeastBytes));
  auto& blocks = free_[size];
  void* block = nullptr;
  if (!blocks.empty()) {
    block = blocks.back();
    blocks.pop_back();
  } else {
    if (size > kBytes - used_) throw std::bad_alloc();
    block = device_ + used_;
    used_ += size;
  }
  sizes_[block] = size;
  std::memset(Content(block), kNan, bytes);
  return block;
}

void DeviceMemory::Free(void* device) {
  if (device == nullptr) return;
  const std::lock_guard lock(mutex_);
  const auto found = sizes_.find(device);
  free_[found->second].push_back(device);
  sizes_.erase(found);
}

bool DeviceMemory::Contains(const void* device) const { return device >= device_ && device < device_ + kBytes; }

void* DeviceMemory::Content(const void* device) const {
  if (device == nullptr) return nullptr;
  if (!Contains(device)) throw std::logic_error("a pointer that is not the device's was given to one of its kernels");
  return content_ + (static_cast<const char*>(device) - device_);
}

}  // namespace diffsac::testing
