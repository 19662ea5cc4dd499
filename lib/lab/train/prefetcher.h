#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <future>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace diffsac {

/// Makes items ahead on worker threads and hands them over in the order of their index, so that what the consumer sees
/// does not depend on the number of workers. At most `queue_depth` items are in the making or waiting.
///
/// An exception of `make` is rethrown by the `Next` whose item it concerns, and by every later one. The destructor
/// waits for the items in the making and drops what was not consumed. One consumer at a time.
template <class T>
class Prefetcher {
 public:
  /// `make` must be thread-safe and depend on the index alone. workers 0: no threads, `Next` makes the item itself.
  /// queue_depth is raised to the number of workers where it is smaller.
  Prefetcher(std::function<T(std::uint64_t index)> make, int workers, int queue_depth, std::uint64_t first_index = 0)
      : make_(std::move(make)), next_(first_index) {
    for (int i = std::max({workers, queue_depth, 1}); i > 0; --i) Ask();
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
    if (error_) std::rethrow_exception(error_);
    const auto start = std::chrono::steady_clock::now();
    std::future<T> made = std::move(ahead_.front());
    ahead_.pop_front();
    if (workers_.empty()) Take()();
    made.wait();
    waited_ += std::chrono::steady_clock::now() - start;
    try {
      T item = made.get();
      Ask();
      return item;
    } catch (...) {
      error_ = std::current_exception();
      throw;
    }
  }

  /// How long the consumer has spent in `Next` altogether: the time that the data cost it.
  double wait_seconds() const { return waited_.count(); }

 private:
  using Task = std::packaged_task<T()>;

  void Ask() {
    Task task([this, index = next_++] { return make_(index); });
    ahead_.push_back(task.get_future());
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    asked_.notify_one();
  }

  Task Take() {
    Task task = std::move(tasks_.front());
    tasks_.pop_front();
    return task;
  }

  void Work() {
    for (std::unique_lock lock(mutex_);; lock.lock()) {
      asked_.wait(lock, [&] { return stop_ || !tasks_.empty(); });
      if (stop_) return;
      Task task = Take();
      lock.unlock();
      task();
    }
  }

  void Stop() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    asked_.notify_all();
    for (std::thread& worker : workers_) worker.join();
  }

  std::function<T(std::uint64_t)> make_;
  std::uint64_t next_;
  std::deque<std::future<T>> ahead_;  // The consumer's.
  std::exception_ptr error_;
  std::chrono::duration<double> waited_{0.0};
  std::mutex mutex_;  // Guards the tasks and stop_.
  std::condition_variable asked_;
  std::deque<Task> tasks_;
  bool stop_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace diffsac
