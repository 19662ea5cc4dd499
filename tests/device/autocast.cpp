// Mixed precision on the test's device: CUDA's lists of operations.
#include <ATen/autocast_mode.h>
#include <torch/library.h>
#include <torch/torch.h>

namespace {

#define DIFFSAC_LOWER(...) KERNEL_PRIVATEUSEONE(__VA_ARGS__, lower_precision_fp)
#define DIFFSAC_FP32(...) KERNEL_PRIVATEUSEONE(__VA_ARGS__, fp32)
#define DIFFSAC_FP32_OPTIONAL(...) KERNEL_PRIVATEUSEONE(__VA_ARGS__, fp32_set_opt_dtype)
#define DIFFSAC_PROMOTE(...) KERNEL_PRIVATEUSEONE(__VA_ARGS__, promote)

TORCH_LIBRARY_IMPL(_, AutocastPrivateUse1, m) { m.fallback(torch::CppFunction::makeFallthrough()); }

TORCH_LIBRARY_IMPL(aten, AutocastPrivateUse1, m) {
  AT_FORALL_LOWER_PRECISION_FP(DIFFSAC_LOWER)
  AT_FORALL_FP32(DIFFSAC_FP32)
  AT_FORALL_FP32_SET_OPT_DTYPE(DIFFSAC_FP32_OPTIONAL)
  AT_FORALL_PROMOTE(DIFFSAC_PROMOTE)
}

}  // namespace
