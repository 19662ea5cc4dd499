// The kernels that the test's device must have itself: memory, copies and views. Everything else is Fallback.
#include <ATen/EmptyTensor.h>
#include <ATen/native/DispatchStub.h>
#include <ATen/native/transformers/attention.h>
#include <ATen/native/transformers/sdp_utils_cpp.h>
#include <ATen/ops/_reshape_alias_native.h>
#include <ATen/ops/as_strided_native.h>
#include <ATen/ops/set_native.h>
#include <ATen/ops/unfold_native.h>
#include <ATen/ops/view_native.h>
#include <torch/library.h>
#include <torch/torch.h>

#include <algorithm>
#include <cstring>

#include "device/device_memory.h"
#include "device/fallback.h"

namespace diffsac::testing {
namespace {

using torch::Tensor;
template <class T>
using Optional = std::optional<T>;

constexpr c10::DispatchKeySet kKeys(c10::DispatchKey::PrivateUse1);

c10::Allocator* OwnAllocator() { return c10::GetAllocator(c10::DeviceType::PrivateUse1); }

Tensor Empty(c10::IntArrayRef size, Optional<c10::ScalarType> type, Optional<c10::Layout>, Optional<c10::Device> device,
             Optional<bool>, Optional<c10::MemoryFormat> format) {
  const c10::DeviceGuard guard(*device);
  return at::detail::empty_generic(size, OwnAllocator(), kKeys, c10::dtype_or_default(type), format);
}

Tensor EmptyStrided(c10::IntArrayRef size, c10::IntArrayRef stride, Optional<c10::ScalarType> type,
                    Optional<c10::Layout>, Optional<c10::Device> device, Optional<bool>) {
  const c10::DeviceGuard guard(*device);
  return at::detail::empty_strided_generic(size, stride, OwnAllocator(), kKeys, c10::dtype_or_default(type));
}

Tensor CopyFrom(const Tensor& from, const Tensor& to, bool) {
  OnHost(to).copy_(OnHost(from));
  return to;
}

const Tensor& Resize(const Tensor& tensor, c10::IntArrayRef size, Optional<c10::MemoryFormat>) {
  auto* own = tensor.unsafeGetTensorImpl();
  const std::size_t bytes = at::detail::computeStorageNbytesContiguous(
      size, tensor.itemsize(), static_cast<std::size_t>(tensor.storage_offset()));
  const c10::Storage& storage = tensor.storage();
  if (bytes > storage.nbytes()) {
    const c10::DeviceGuard guard(tensor.device());
    auto data = OwnAllocator()->allocate(bytes);
    if (storage.nbytes() > 0) OwnAllocator()->copy_data(data.get(), storage.data(), storage.nbytes());
    storage.set_data_ptr(std::move(data));
    storage.set_nbytes(bytes);
  }
  own->set_sizes_contiguous(size);
  return tensor;
}

Tensor CopyFromAndResize(const Tensor& from, const Tensor& to) {
  Resize(to, from.sizes(), {});
  return CopyFrom(from, to, false);
}

at::Scalar LocalScalar(const Tensor& tensor) { return OnHost(tensor).item(); }

// Module::to replaces the data of its parameters in place where this says that it may.
bool HasCompatibleShallowCopyType(const Tensor& self, const Tensor& from) {
  const auto dense = [](const Tensor& tensor) { return tensor.is_cpu() || tensor.is_privateuseone(); };
  return dense(self) && dense(from) && self.layout() == from.layout();
}

std::int64_t AttentionByParts(const Tensor&, const Tensor&, const Tensor&, const Optional<Tensor>&, double, bool,
                              Optional<double>, bool) {
  return static_cast<std::int64_t>(sdp::SDPBackend::math);
}

TORCH_LIBRARY_IMPL(_, PrivateUse1, m) { m.fallback(torch::CppFunction::makeFromBoxedFunction<&Fallback>()); }

TORCH_LIBRARY_IMPL(aten, PrivateUse1, m) {
  m.impl("empty.memory_format", Empty);
  m.impl("empty_strided", EmptyStrided);
  m.impl("_copy_from", CopyFrom);
  m.impl("_copy_from_and_resize", CopyFromAndResize);
  m.impl("resize_", Resize);
  m.impl("_local_scalar_dense", LocalScalar);
  m.impl("_has_compatible_shallow_copy_type", HasCompatibleShallowCopyType);
  m.impl("as_strided", at::native::as_strided_tensorimpl);
  m.impl("view", at::native::view);
  m.impl("_reshape_alias", at::native::_reshape_alias);
  m.impl("unfold", at::native::unfold);
  m.impl("set_.source_Storage_storage_offset", at::native::set_storage_cpu_);
  m.impl("_fused_sdp_choice", AttentionByParts);
}

}  // namespace
}  // namespace diffsac::testing

namespace at::native {
REGISTER_PRIVATEUSE1_DISPATCH(_fused_sdp_choice_stub, &diffsac::testing::AttentionByParts)
}
