#include "lab/torch/nccl_backend.h"

#ifdef DIFFSAC_NCCL
#include <ATen/cuda/CUDAContext.h>
#include <torch/csrc/distributed/c10d/PrefixStore.hpp>
#include <torch/csrc/distributed/c10d/ProcessGroupNCCL.hpp>
#endif

namespace diffsac {

c10::intrusive_ptr<c10d::Backend> MakeNcclBackend([[maybe_unused]] const c10::intrusive_ptr<c10d::Store>& store,
                                                  [[maybe_unused]] int rank, [[maybe_unused]] int size,
                                                  [[maybe_unused]] std::chrono::milliseconds timeout) {
#ifdef DIFFSAC_NCCL
  auto options = c10d::ProcessGroupNCCL::Options::create();
  options->timeout = timeout;
  const auto own = c10::make_intrusive<c10d::PrefixStore>("nccl", store);
  return c10::make_intrusive<c10d::ProcessGroupNCCL>(own, rank, size, options);
#else
  return nullptr;
#endif
}

std::int64_t GpuIdentity([[maybe_unused]] int index) {
#ifdef DIFFSAC_NCCL
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char byte : at::cuda::getDeviceProperties(index)->uuid.bytes)
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  return static_cast<std::int64_t>(hash >> 1);
#else
  return 0;
#endif
}

}  // namespace diffsac
