#include "diffsac/core/memory.h"

#include <sys/resource.h>

#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace diffsac {

void KeepFreedMemory() {
#ifdef __GLIBC__
  // No request is mapped by itself, and what is free at the end of the heap is given back from here on only.
  constexpr int kGiveBackAbove = 1 << 30;
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, kGiveBackAbove);
#endif
}

double PeakMemoryMib() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace diffsac
