#define DIFFSAC_KERNELS kernels_avx512
#define DIFFSAC_KERNELS_NAME "avx512"
#include "diffsac/guidance/engine/kernels_impl.h"
