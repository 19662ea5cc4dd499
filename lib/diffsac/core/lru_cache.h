#pragma once

#include <algorithm>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace diffsac {

/// The values that were asked for last, by what they are made of. Thread-safe.
template <class Value, class Key = std::string>
class LruCache {
 public:
  explicit LruCache(int capacity) : capacity_(static_cast<std::size_t>(capacity)) {}

  /// Value(key), where it is not kept.
  std::shared_ptr<const Value> Get(const Key& key) {
    return Get(key, [&key] { return std::make_shared<const Value>(key); });
  }

  /// make(), where it is not kept: a shared pointer.
  template <class Make>
  std::shared_ptr<const Value> Get(const Key& key, const Make& make) {
    {
      const std::lock_guard lock(mutex_);
      if (const auto found = Find(key); found != kept_.end()) {
        kept_.splice(kept_.begin(), kept_, found);
        return found->second;
      }
    }
    // Making takes longest, so other threads need not wait for it; two may make the same value, of which one is kept.
    std::shared_ptr<const Value> value = make();
    const std::lock_guard lock(mutex_);
    if (const auto found = Find(key); found != kept_.end()) return found->second;
    kept_.emplace_front(key, value);
    if (kept_.size() > capacity_) kept_.pop_back();
    return value;
  }

 private:
  auto Find(const Key& key) {
    return std::find_if(kept_.begin(), kept_.end(), [&](const auto& entry) { return entry.first == key; });
  }

  std::size_t capacity_;
  std::mutex mutex_;
  std::list<std::pair<Key, std::shared_ptr<const Value>>> kept_;
};

}  // namespace diffsac
