#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace diffsac {

/// Makes items ahead on worker threads and hands them over in the order of their index, so that what the consumer sees
/// does not depend on the number of workers. At most `queue_depth` items are in the making or waiting.
///
/// An exception of `make` is rethrown by the `Next` whose item it concerns, and by every later one. The destructor
/// waits for the items in the making and drops what was not consumed. One consumer at a time.
///
/// Example:
/// ```
/// Prefetcher<Batch> batches([&](std::uint64_t step) { return MakeBatch(dataset, step); }, 2, 8, first_step);
/// Batch batch = batches.Next();
/// log("waited {:.1f} s for data", batches.wait_seconds());
/// ```
template <class T>
class Prefetcher {
 public:
  /// `make` must be thread-safe and depend on the index alone. workers 0: no threads, `Next` makes the item itself.
  /// queue_depth is raised to the number of workers where it is smaller.
  Prefetcher(std::function<T(std::uint64_t index)> make, int workers, int queue_depth, std::uint64_t first_index = 0)
      : make_(std::move(make)),
        slots_(static_cast<std::size_t>(std::max({workers, queue_depth, 1}))),
        next_claimed_(first_index),
        next_consumed_(first_index) {
    try {
      for (int i = 0; i < workers; ++i) workers_.emplace_back([this] { Work(); });
    } catch (...) {
      Stop();
      throw;
    }
  }

  ~Prefetcher() { Stop(); }
  Prefetcher(const Prefetcher&) = delete;
  Prefetcher& operator=(const Prefetcher&) = delete;

  /// The next item in order; waits for it.
  T Next() {
    const auto start = std::chrono::steady_clock::now();
    if (workers_.empty()) return MakeHere(start);
    std::unique_lock lock(mutex_);
    Slot& slot = SlotOf(next_consumed_);
    item_made_.wait(lock, [&] { return slot.item.has_value() || slot.error; });
    AddWait(start);
    if (slot.error) std::rethrow_exception(slot.error);
    T item = std::move(*slot.item);
    slot.item.reset();
    ++next_consumed_;
    lock.unlock();
    slot_freed_.notify_one();
    return item;
  }

  /// How long the consumer has spent in `Next` altogether: the time that the data cost it.
  double wait_seconds() const { return std::chrono::duration<double>(Duration(waited_.load())).count(); }

 private:
  using Duration = std::chrono::steady_clock::duration;

  struct Slot {
    std::optional<T> item;
    std::exception_ptr error;
  };

  Slot& SlotOf(std::uint64_t index) { return slots_[index % slots_.size()]; }

  void AddWait(std::chrono::steady_clock::time_point start) {
    waited_ += (std::chrono::steady_clock::now() - start).count();
  }

  T MakeHere(std::chrono::steady_clock::time_point start) {
    T item = make_(next_consumed_);
    ++next_consumed_;
    AddWait(start);
    return item;
  }

  void Work() {
    std::unique_lock lock(mutex_);
    for (;;) {
      slot_freed_.wait(lock, [&] { return stop_ || next_claimed_ < next_consumed_ + slots_.size(); });
      if (stop_) return;
      // Indices are claimed in order, so every index before a failing one has a worker and will be delivered.
      const std::uint64_t index = next_claimed_++;
      lock.unlock();
      Slot made = Make(index);
      lock.lock();
      if (made.error) stop_ = true;
      SlotOf(index) = std::move(made);
      item_made_.notify_one();
      if (stop_) slot_freed_.notify_all();
    }
  }

  Slot Make(std::uint64_t index) {
    Slot slot;
    try {
      slot.item.emplace(make_(index));
    } catch (...) {
      slot.error = std::current_exception();
    }
    return slot;
  }

  void Stop() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    slot_freed_.notify_all();
    for (std::thread& worker : workers_) worker.join();
  }

  std::function<T(std::uint64_t)> make_;
  std::vector<Slot> slots_;
  std::uint64_t next_claimed_;
  std::uint64_t next_consumed_;
  bool stop_ = false;
  std::mutex mutex_;
  std::condition_variable item_made_;
  std::condition_variable slot_freed_;
  std::atomic<Duration::rep> waited_{0};
  std::vector<std::thread> workers_;
};

}  // namespace diffsac
