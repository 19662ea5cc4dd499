#pragma once

#include <ATen/core/stack.h>
#include <torch/types.h>

namespace c10 {
class OperatorHandle;
}

namespace diffsac::testing {

/// A tensor of the processor over the content of one of the test's device, of the same sizes and strides. Others are
/// returned as they are.
torch::Tensor OnHost(const torch::Tensor& tensor);

/// Any operation that the device has no kernel for: the CPU's, over the device's content.
///
/// First it throws c10::Error where a tensor argument, one of a list or an optional one, is not on the device of the
/// others, as CUDA does. As there, a tensor without dimensions may be on the CPU (but not in a list), and so may the
/// indices of `index` and `index_put_`. Operations that LibTorch composes of others (linear, matmul, softmax) are
/// checked in their parts.
void Fallback(const c10::OperatorHandle& op, torch::jit::Stack* stack);

}  // namespace diffsac::testing
