#define DIFFSAC_KERNELS kernels_baseline
#define DIFFSAC_KERNELS_NAME "baseline"
#include "diffsac/guidance/engine/kernels_impl.h"
