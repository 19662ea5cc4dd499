#include "lab/torch/nccl_backend.h"

#ifdef DIFFSAC_NCCL
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

}  // namespace diffsac
