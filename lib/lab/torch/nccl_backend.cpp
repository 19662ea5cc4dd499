#include "lab/torch/nccl_backend.h"

#ifdef DIFFSAC_NCCL
#include <ATen/cuda/CUDAContext.h>
#include <torch/csrc/distributed/c10d/PrefixStore.hpp>
#include <torch/csrc/distributed/c10d/ProcessGroupNCCL.hpp>

#include "diffsac/core/random.h"
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
  const auto& uuid = at::cuda::getDeviceProperties(index)->uuid;
  return static_cast<std::int64_t>(Rng().Fork({uuid.bytes, sizeof uuid.bytes}).Seed() >> 1);
#else
  return 0;
#endif
}

}  // namespace diffsac
