#define DIFFSAC_KERNELS kernels_baseline
#define DIFFSAC_KERNELS_NAME "baseline"
#include "diffsac/inference/kernels_impl.h"
