#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <vector>

namespace diffsac::testing {

/// Memory of the test's own device. What tensors hold are addresses that no processor may read or write, as those of a
/// GPU: code that takes such a pointer for its own ends with a segmentation fault. The content lies elsewhere, where
/// the device's kernels alone look.
///
/// Safe for several threads.
class DeviceMemory {
 public:
  static DeviceMemory& Instance();

  /// Null for no bytes. The content is NaN. Throws std::bad_alloc where there is no more.
  void* Allocate(std::size_t bytes);
  void Free(void* device);
  bool Contains(const void* device) const;
  /// Where the content is. Throws std::logic_error for any other pointer but null, which stays null.
  void* Content(const void* device) const;

 private:
  DeviceMemory();

  std::mutex mutex_;
  char* device_;   // kBytes addresses without access
  char* content_;  // as many with it
  std::size_t used_ = 0;
  std::map<const void*, std::size_t> sizes_;
  std::map<std::size_t, std::vector<void*>> free_;  // by size, a power of two
};

}  // namespace diffsac::testing
