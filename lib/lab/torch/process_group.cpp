#include "lab/torch/process_group.h"

#include <torch/torch.h>

// Here rather than on the command line, where it would keep the precompiled header out.
#define USE_C10D_GLOO
#include <torch/csrc/distributed/c10d/PrefixStore.hpp>
#include <torch/csrc/distributed/c10d/ProcessGroupGloo.hpp>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>

#include <algorithm>
#include <cstdio>

#include "diffsac/core/logging.h"
#include "lab/torch/nccl_backend.h"

namespace diffsac {
namespace {

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string Who(const ProcessPlace& place) {
  return "process " + std::to_string(place.rank) + " of " + std::to_string(place.size);
}

std::string Seconds(std::chrono::milliseconds time) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", static_cast<double>(time.count()) / 1000.0);
  return text;
}

c10::intrusive_ptr<c10d::Store> MakeStore(const ProcessPlace& place, std::chrono::milliseconds timeout) {
  c10d::TCPStoreOptions options;
  options.port = static_cast<std::uint16_t>(place.port);
  options.isServer = place.rank == 0 && !place.launcher_keeps_store;
  options.waitWorkers = false;
  options.timeout = timeout;
  c10::intrusive_ptr<c10d::Store> store = c10::make_intrusive<c10d::TCPStore>(place.address, options);
  return c10::make_intrusive<c10d::PrefixStore>(place.store_prefix + "/diffsac", store);
}

}  // namespace

struct ProcessGroup::Impl {
  std::chrono::milliseconds timeout;
  c10::intrusive_ptr<c10d::Store> store;
  c10::intrusive_ptr<c10d::Backend> gloo;
  c10::intrusive_ptr<c10d::Backend> nccl;  // Made when the first tensors on a GPU come; null where the build has none.
  bool nccl_tried = false;

  // Who sums tensors of this kind where they are; null: nobody, they travel through the processor's memory.
  c10d::Backend* BackendOf(const ProcessPlace& place, const torch::Tensor& tensor) {
    if (tensor.is_cpu()) return gloo.get();
    if (!tensor.is_cuda()) return nullptr;
    if (!nccl_tried) {
      const bool shared = ShareGpu(place, tensor.device().index());
      if (!shared) nccl = MakeNcclBackend(store, place.rank, place.size, timeout);
      if (!nccl)
        LogInfo(std::string(shared ? "processes share a GPU, which NCCL refuses" : "built without NCCL") +
                ": gradients travel through the processors' memory");
    }
    nccl_tried = true;
    return nccl.get();
  }

  // Whether two of the processes have the same GPU; all ask at once.
  bool ShareGpu(const ProcessPlace& place, int index) const {
    std::vector<torch::Tensor> all = {torch::zeros({place.size}, torch::kLong)};
    std::int64_t* const gpus = all.front().data_ptr<std::int64_t>();
    gpus[place.rank] = GpuIdentity(index);
    gloo->allreduce(all)->wait();
    std::sort(gpus, gpus + place.size);
    return std::adjacent_find(gpus, gpus + place.size) != gpus + place.size && gpus[0] != 0;
  }
};

template <class Work>
auto ProcessGroup::Guarded(const Work& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    throw GroupLost(Who(place_) + ": another process has ended, or did not answer within " + Seconds(impl_->timeout) +
                    " (" + FirstLine(error.what()) + ")");
  }
}

ProcessGroup::ProcessGroup(const ProcessPlace& place, double timeout_s) : place_(place), impl_(new Impl) {
  impl_->timeout = std::chrono::milliseconds(static_cast<std::int64_t>(timeout_s * 1000.0));
  try {
    impl_->store = MakeStore(place, impl_->timeout);
    auto options = c10d::ProcessGroupGloo::Options::create_default(impl_->timeout);
    const auto store = c10::make_intrusive<c10d::PrefixStore>("gloo", impl_->store);
    impl_->gloo = c10::make_intrusive<c10d::ProcessGroupGloo>(store, place.rank, place.size, options);
    // One that connects to all may end, for a mistake in its configuration, say, while others still connect.
    std::vector<torch::Tensor> all_here = {torch::zeros({1})};
    impl_->gloo->allreduce(all_here)->wait();
  } catch (const std::exception& error) {
    throw Error(Who(place) + ": cannot join the others at " + place.address + ":" + std::to_string(place.port) + " (" +
                FirstLine(error.what()) + ")");
  }
}

ProcessGroup::~ProcessGroup() = default;

void ProcessGroup::Sum(std::vector<double>* values) {
  auto tensor = torch::from_blob(values->data(), {static_cast<std::int64_t>(values->size())}, torch::kDouble);
  std::vector<torch::Tensor> tensors = {tensor};
  Guarded([&] { impl_->gloo->allreduce(tensors)->wait(); });
}

void ProcessGroup::Sum(const std::vector<at::Tensor>& tensors) {
  if (tensors.empty()) return;
  const torch::NoGradGuard no_grad;
  std::vector<torch::Tensor> parts;
  for (const auto& tensor : tensors) parts.push_back(tensor.detach().flatten());
  Guarded([&] {
    c10d::Backend* backend = impl_->BackendOf(place_, tensors.front());
    std::vector<torch::Tensor> whole = {torch::cat(parts)};  // One: what c10d wants.
    if (backend == nullptr) whole[0] = whole[0].cpu();
    (backend == nullptr ? impl_->gloo.get() : backend)->allreduce(whole)->wait();
    std::int64_t first = 0;
    for (const auto& tensor : tensors) {
      tensor.detach().copy_(whole[0].slice(0, first, first + tensor.numel()).view_as(tensor));
      first += tensor.numel();
    }
  });
}

std::unique_ptr<ProcessGroup> JoinProcessGroup(double timeout_s) {
  const ProcessPlace place = FindProcessPlace();
  return place.size == 1 ? nullptr : std::make_unique<ProcessGroup>(place, timeout_s);
}

std::string LocalDevice(const ProcessPlace& place, const std::string& device) {
  if ((device != "auto" && device != "cuda") || !torch::cuda::is_available()) return device;
  return "cuda:" + std::to_string(place.local_rank % static_cast<int>(torch::cuda::device_count()));
}

}  // namespace diffsac
