#pragma once

#include <torch/csrc/distributed/c10d/Backend.hpp>
#include <torch/csrc/distributed/c10d/Store.hpp>

#include <chrono>
#include <cstdint>

namespace diffsac {

/// c10d over NCCL, for tensors on GPUs. Null where the build has no NCCL (CMake: DIFFSAC_CUDA and nccl.h).
c10::intrusive_ptr<c10d::Backend> MakeNcclBackend(const c10::intrusive_ptr<c10d::Store>& store, int rank, int size,
                                                  std::chrono::milliseconds timeout);

/// What tells the GPU of an index from all others, on whatever machine and under whatever index; 0 without NCCL.
std::int64_t GpuIdentity(int index);

}  // namespace diffsac
