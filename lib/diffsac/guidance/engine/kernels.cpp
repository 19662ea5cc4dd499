#include "diffsac/guidance/engine/kernels.h"

namespace diffsac {

namespace kernels_baseline {
extern const Kernels kKernels;
}
#ifdef DIFFSAC_X86_KERNELS
namespace kernels_avx2 {
extern const Kernels kKernels;
}
namespace kernels_avx512 {
extern const Kernels kKernels;
}
#endif

KernelList AvailableKernels() {
  KernelList list = {{}, 0};
#ifdef DIFFSAC_X86_KERNELS
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("fma"))
    list.all[list.count++] = &kernels_avx512::kKernels;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) list.all[list.count++] = &kernels_avx2::kKernels;
#endif
  list.all[list.count++] = &kernels_baseline::kKernels;
  return list;
}

const Kernels& BestKernels() {
  static const Kernels& best = *AvailableKernels().all[0];
  return best;
}

}  // namespace diffsac
