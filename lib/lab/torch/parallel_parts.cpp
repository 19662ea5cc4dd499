#include "lab/torch/parallel_parts.h"

#include <atomic>
#include <exception>

namespace diffsac {

// at::parallel_for is a template that runs in turn in files that are compiled without OpenMP, as ours are; this is the
// one file that is not.
void ParallelParts(int count, const std::function<void(int)>& body) {
  std::atomic_flag failed = ATOMIC_FLAG_INIT;
  std::exception_ptr error;
#pragma omp parallel for schedule(static)
  for (int i = 0; i < count; ++i) {
    try {
      body(i);
    } catch (...) {
      if (!failed.test_and_set()) error = std::current_exception();
    }
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace diffsac
