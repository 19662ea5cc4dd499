#pragma once

#include <algorithm>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace diffsac {

/// The values that were asked for last, each made from the path of its file: Value(path). Thread-safe.
template <class Value>
class LruCache {
 public:
  explicit LruCache(int capacity) : capacity_(static_cast<std::size_t>(capacity)) {}

  std::shared_ptr<const Value> Get(const std::string& path) {
    {
      const std::lock_guard lock(mutex_);
      const auto found =
          std::find_if(kept_.begin(), kept_.end(), [&](const auto& entry) { return entry.first == path; });
      if (found != kept_.end()) {
        kept_.splice(kept_.begin(), kept_, found);
        return found->second;
      }
    }
    // Reading takes longest, so other threads need not wait for it; two may read the same file.
    auto value = std::make_shared<const Value>(path);
    const std::lock_guard lock(mutex_);
    kept_.emplace_front(path, value);
    if (kept_.size() > capacity_) kept_.pop_back();
    return value;
  }

 private:
  std::size_t capacity_;
  std::mutex mutex_;
  std::list<std::pair<std::string, std::shared_ptr<const Value>>> kept_;
};

}  // namespace diffsac
