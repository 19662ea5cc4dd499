#include "lab/config/process.h"

#include <sys/resource.h>

#include <cstdlib>
#ifdef __linux__
#include <unistd.h>
#endif
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

void WaitPassively([[maybe_unused]] char** argv) {
#ifdef __linux__
  constexpr const char* kPolicy = "OMP_WAIT_POLICY";
  if (std::getenv(kPolicy) != nullptr || ::setenv(kPolicy, "passive", 0) != 0) return;
  ::execv("/proc/self/exe", argv);
#endif
}

}  // namespace diffsac
