#include "lab/eval/shard.h"

#include <charconv>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

// The whole of a text as a number, or 0, which is never valid here.
int PositiveNumber(const std::string& text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc() && result.ptr == end && value > 0 ? value : 0;
}

}  // namespace

Shard ShardFromText(const std::string& text) {
  const std::size_t slash = text.find('/');
  Shard shard{0, 0};
  if (slash != std::string::npos)
    shard = {PositiveNumber(text.substr(0, slash)), PositiveNumber(text.substr(slash + 1))};
  if (shard.index < 1 || shard.index > shard.count)
    throw Error("--shard: expected i/n with 1 <= i <= n, as in 2/3; got '" + text + "'");
  return shard;
}

std::string ToString(const Shard& shard) { return std::to_string(shard.index) + "/" + std::to_string(shard.count); }

std::vector<std::size_t> ShardPositions(std::size_t count, std::size_t batch, const Shard& shard) {
  const auto shards = static_cast<std::size_t>(shard.count), mine = static_cast<std::size_t>(shard.index - 1);
  std::vector<std::size_t> positions;
  for (std::size_t i = 0; i < count; ++i)
    if (i / batch % shards == mine) positions.push_back(i);
  return positions;
}

}  // namespace diffsac
