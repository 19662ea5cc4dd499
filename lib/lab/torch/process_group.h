#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/status.h"
#include "lab/torch/process_place.h"

namespace at {
class Tensor;
}

namespace diffsac {

/// Another process of the group has ended, or did not answer in time.
class GroupLost : public Error {
 public:
  using Error::Error;
};

/// Processes that work together: LibTorch's c10d over Gloo and, for sums of tensors on GPUs, over NCCL where the build
/// has it. All processes make the same calls in the same order; each call waits for the others, at most for the
/// timeout, and throws GroupLost when one of them is gone.
class ProcessGroup {
 public:
  /// Waits until all processes have come. Throws Error when they don't within the timeout.
  ProcessGroup(const ProcessPlace& place, double timeout_s);
  ~ProcessGroup();

  const ProcessPlace& place() const { return place_; }
  int rank() const { return place_.rank; }
  int size() const { return place_.size; }
  bool main() const { return place_.rank == 0; }

  /// Each value becomes its sum over the processes, the same to the last bit everywhere.
  void Sum(std::vector<double>* values);
  /// The same for tensors of one type and device, such as gradients: copied into one that travels, and back.
  void Sum(const std::vector<at::Tensor>& tensors);

 private:
  struct Impl;
  template <class Work>
  auto Guarded(const Work& work);

  ProcessPlace place_;
  std::unique_ptr<Impl> impl_;
};

/// The group of the launcher that started this program (FindProcessPlace); null where it runs alone.
std::unique_ptr<ProcessGroup> JoinProcessGroup(double timeout_s);

/// How long a process waits for the others unless told otherwise; validation and the last shard fall in it.
inline constexpr double kGroupTimeoutSeconds = 1800.0;

/// "cuda:1" for the second process on a machine with several GPUs that asks for "cuda" or "auto"; else as asked.
std::string LocalDevice(const ProcessPlace& place, const std::string& device);

}  // namespace diffsac
