#include "diffsac/core/parallel.h"

#include <sched.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <thread>

#if defined(DIFFSAC_SANITIZE_THREADS)
#include <sanitizer/tsan_interface.h>
#endif

namespace diffsac {
namespace {

// Tells the thread sanitizer what TBB, which it does not see, guarantees: a loop's bodies run after what came before
// the loop and before what comes after it. It says nothing of the bodies among each other, whose races stay visible.
class LoopOrder {
 public:
#if defined(DIFFSAC_SANITIZE_THREADS)
  LoopOrder() { __tsan_release(&before_); }
  ~LoopOrder() { __tsan_acquire(&after_); }
  void Enter() { __tsan_acquire(&before_); }
  void Leave() { __tsan_release(&after_); }

 private:
  char before_ = 0, after_ = 0;
#else
  void Enter() {}
  void Leave() {}
#endif
};

/// Also where a body throws.
struct PartOfLoop {
  explicit PartOfLoop(LoopOrder* order) : order(order) { order->Enter(); }
  ~PartOfLoop() { order->Leave(); }
  LoopOrder* order;
};

}  // namespace

int HardwareThreads() {
  // The affinity mask, unlike hardware_concurrency of every library, knows taskset and containers' CPU sets.
  cpu_set_t usable;
  if (sched_getaffinity(0, sizeof(usable), &usable) == 0) return std::max(1, CPU_COUNT(&usable));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void ParallelFor(std::int64_t count, int threads, const std::function<void(std::int64_t)>& body) {
  // More than the cores gains nothing, and TBB would warn on the terminal.
  const int cores = HardwareThreads();
  threads = threads <= 0 ? cores : std::min(threads, cores);
  if (threads == 1 || count <= 1) {
    for (std::int64_t i = 0; i < count; ++i) body(i);
    return;
  }
  // An arena of its own bounds the threads, and keeps a waiting thread from picking up an outer loop's work. TBB
  // cancels the loop at the first exception and rethrows it here.
  tbb::task_arena arena(threads);
  LoopOrder order;
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, count), [&](const tbb::blocked_range<std::int64_t>& part) {
      const PartOfLoop part_of_loop(&order);
      for (std::int64_t i = part.begin(); i != part.end(); ++i) body(i);
    });
  });
}

}  // namespace diffsac
