#include "device/fallback.h"

#include <ATen/core/dispatch/Dispatcher.h>
#include <torch/library.h>
#include <torch/torch.h>

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "device/device_memory.h"

namespace diffsac::testing {

torch::Tensor OnHost(const torch::Tensor& tensor) {
  if (!tensor.defined() || !tensor.is_privateuseone()) return tensor;
  void* content = DeviceMemory::Instance().Content(tensor.data_ptr());
  return torch::from_blob(content, tensor.sizes(), tensor.strides(),
                          tensor.options().device(torch::kCPU).requires_grad(false));
}

namespace {

using c10::IValue;

// One tensor among the arguments of a call.
struct Place {
  std::string name;
  torch::Tensor tensor;
  bool in_list;
};

void AddPlaces(const std::string& name, const IValue& value, std::vector<Place>* places) {
  if (value.isTensor()) {
    if (value.toTensor().defined()) places->push_back({name, value.toTensor(), false});
  } else if (value.isTensorList()) {
    std::size_t k = 0;
    for (const torch::Tensor& tensor : value.toTensorVector())
      places->push_back({name + "[" + std::to_string(k++) + "]", tensor, true});
  } else if (value.isOptionalTensorList()) {
    std::size_t k = 0;
    for (const std::optional<torch::Tensor>& tensor : value.toOptionalTensorVector()) {
      if (tensor && tensor->defined()) places->push_back({name + "[" + std::to_string(k) + "]", *tensor, true});
      ++k;
    }
  }
}

bool TakesIndicesOfCpu(const std::string& op, const std::string& argument) {
  static const std::set<std::string> ops = {"aten::index", "aten::index_put_", "aten::_index_put_impl_"};
  return ops.contains(op) && argument.starts_with("indices[");
}

// The device of the call. Throws where there are several.
c10::Device CheckPlaces(const c10::FunctionSchema& schema, const std::vector<Place>& places) {
  const Place* first = nullptr;
  for (const Place& place : places)
    if (first == nullptr && place.tensor.is_privateuseone()) first = &place;
  TORCH_INTERNAL_ASSERT(first != nullptr, schema.name(), ": a call without a tensor of the device");
  for (const Place& place : places) {
    if (place.tensor.device() == first->tensor.device()) continue;
    const bool scalar = place.tensor.is_cpu() && place.tensor.dim() == 0 && !place.in_list;
    const bool index = place.tensor.is_cpu() && TakesIndicesOfCpu(schema.name(), place.name);
    TORCH_CHECK(scalar || index, schema.name(), ": expected all tensors to be on the same device, but '", place.name,
                "' is on ", place.tensor.device(), " and '", first->name, "' on ", first->tensor.device());
  }
  return first->tensor.device();
}

// A call of the device's with its tensors seen from the processor.
class HostCall {
 public:
  HostCall(const c10::FunctionSchema& schema, c10::Device device) : schema_(schema), device_(device) {}

  void Give(torch::jit::Stack* stack) {
    const auto& arguments = schema_.arguments();
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      IValue& value = (*stack)[stack->size() - arguments.size() + i];
      if (value.isTensor()) {
        value = Seen(value.toTensor(), arguments[i].is_out());
      } else if (value.isTensorList()) {
        std::vector<torch::Tensor> seen;
        for (const auto& tensor : value.toTensorVector()) seen.push_back(Seen(tensor, arguments[i].is_out()));
        value = c10::List<torch::Tensor>(seen);
      } else if (value.isOptionalTensorList()) {
        c10::List<std::optional<torch::Tensor>> seen;
        for (const auto& tensor : value.toOptionalTensorVector())
          seen.push_back(tensor ? std::optional(Seen(*tensor, false)) : std::nullopt);
        value = seen;
      } else if (value.isDevice()) {
        value = c10::Device(torch::kCPU);
      }
    }
  }

  void Take(torch::jit::Stack* stack) {
    for (const auto& [own, seen] : resized_) {
      own.resize_(seen.sizes());
      own.copy_(seen);
    }
    const auto& returns = schema_.returns();
    for (std::size_t i = 0; i < returns.size(); ++i) {
      const bool writes = returns[i].alias_info() != nullptr && returns[i].alias_info()->isWrite();
      TORCH_CHECK(returns[i].alias_info() == nullptr || writes, schema_.name(), " is a view; ", device_.str(),
                  " needs a kernel of its own for it");
      IValue& value = (*stack)[stack->size() - returns.size() + i];
      if (value.isTensor() && value.toTensor().defined()) {
        value = writes ? OwnOf(value.toTensor()) : value.toTensor().to(device_);
      } else if (value.isTensorList()) {
        std::vector<torch::Tensor> own;
        for (const auto& tensor : value.toTensorVector()) own.push_back(writes ? OwnOf(tensor) : tensor.to(device_));
        value = c10::List<torch::Tensor>(own);
      }
    }
  }

 private:
  // What is written over the content is the device's at once, but for a result that gets its size from the kernel.
  torch::Tensor Seen(const torch::Tensor& tensor, bool out) {
    if (!tensor.defined() || !tensor.is_privateuseone()) return tensor;
    for (const auto& [own, seen] : seen_)
      if (own.is_same(tensor)) return seen;
    const bool resized = out && tensor.numel() == 0;
    auto seen = resized ? torch::empty({0}, tensor.options().device(torch::kCPU)) : OnHost(tensor);
    (resized ? resized_ : seen_).emplace_back(tensor, seen);
    return seen;
  }
  torch::Tensor OwnOf(const torch::Tensor& seen) const {
    for (const auto* pairs : {&seen_, &resized_})
      for (const auto& [own, host] : *pairs)
        if (host.is_same(seen)) return own;
    TORCH_CHECK(false, schema_.name(), ": returns a tensor that is none of its arguments");
  }

  const c10::FunctionSchema& schema_;
  c10::Device device_;
  std::vector<std::pair<torch::Tensor, torch::Tensor>> seen_, resized_;
};

}  // namespace

void Fallback(const c10::OperatorHandle& op, torch::jit::Stack* stack) {
  const auto& schema = op.schema();
  const auto values = torch::jit::last(*stack, schema.arguments().size());
  std::vector<Place> places;
  for (std::size_t i = 0; i < values.size(); ++i) AddPlaces(schema.arguments()[i].name(), values[i], &places);
  HostCall call(schema, CheckPlaces(schema, places));
  call.Give(stack);
  op.redispatchBoxed(c10::DispatchKeySet(c10::DispatchKey::CPU), stack);
  call.Take(stack);
}

}  // namespace diffsac::testing
