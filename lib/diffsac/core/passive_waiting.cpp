#include "diffsac/core/passive_waiting.h"

#include <cstdlib>

#ifdef __linux__
#include <unistd.h>
#endif

namespace diffsac {

void WaitPassively([[maybe_unused]] char** argv) {
#ifdef __linux__
  constexpr const char* kPolicy = "OMP_WAIT_POLICY";
  if (std::getenv(kPolicy) != nullptr || ::setenv(kPolicy, "passive", 0) != 0) return;
  ::execv("/proc/self/exe", argv);
#endif
}

}  // namespace diffsac
