#pragma once

#include <cstddef>  // defines __GLIBC__ where that is the C library

/// Before the definition of a function whose loops go over columns of points: compiles it for AVX2 as well and chooses
/// when the program is loaded. Additions, products, quotients and roots are rounded alike in both (and no a*b+c is
/// contracted), so the results do not depend on the processor.
/// DIFFSAC_BOUND_CLONES: the same for bounds with room for any rounding, on which no result depends.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && !defined(__AVX2__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DIFFSAC_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#define DIFFSAC_BOUND_CLONES __attribute__((target_clones("avx512f", "fma", "default")))
#else
#define DIFFSAC_VECTOR_CLONES
#define DIFFSAC_BOUND_CLONES
#endif
