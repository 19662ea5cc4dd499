#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace diffsac {

/// One of `count` parts of an experiment's problems, for machines that share the work. Every part has problems of every
/// condition and method.
struct Shard {
  int index = 1;  ///< In [1, count].
  int count = 1;
  bool whole() const { return count == 1; }
  bool operator==(const Shard&) const = default;
};

/// "2/3", the second of three. Throws Error for anything else and where 1 ≤ i ≤ n does not hold.
Shard ShardFromText(const std::string& text);

/// "2/3".
std::string ToString(const Shard& shard);

/// The numbers below `count` that a shard takes, ascending. `batch` following ones always stay together, every
/// shard.count-th group of them is this shard's: a network sees the same batches in any sharding, so that its outputs
/// are the same to the last bit. Where there are fewer batches than shards some shards get none.
std::vector<std::size_t> ShardPositions(std::size_t count, std::size_t batch, const Shard& shard);

}  // namespace diffsac
