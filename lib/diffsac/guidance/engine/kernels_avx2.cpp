#define DIFFSAC_KERNELS kernels_avx2
#define DIFFSAC_KERNELS_NAME "avx2"
#include "diffsac/guidance/engine/kernels_impl.h"
