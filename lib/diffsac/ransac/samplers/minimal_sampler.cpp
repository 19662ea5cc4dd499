#include "diffsac/ransac/samplers/minimal_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace diffsac {
namespace {

/// Advances an ascending set to its lexicographic successor; false, leaving it, after the last.
bool Advance(int n, std::vector<int>* set) {
  const int size = static_cast<int>(set->size());
  int position = size - 1;
  while (position >= 0 && (*set)[position] == n - size + position) --position;
  if (position < 0) return false;
  ++(*set)[position];
  for (int i = position + 1; i < size; ++i) (*set)[i] = (*set)[i - 1] + 1;
  return true;
}

}  // namespace

void DrawDistinct(int n, int size, Rng& rng, int* out) {
  if (2 * size > n) {
    rng.Distinct(n, size, out);
    return;
  }
  for (int i = 0; i < size;) {
    const int index = static_cast<int>(rng.Below(static_cast<std::uint64_t>(n)));
    if (std::find(out, out + i, index) == out + i) out[i++] = index;
  }
}

std::vector<int> DrawSets(MinimalSampler& sampler, int set_size, std::int64_t count) {
  std::vector<int> sets, set(std::max(set_size, 0));
  for (std::int64_t i = 0; i < count && sampler.Next(set); ++i) sets.insert(sets.end(), set.begin(), set.end());
  return sets;
}

std::vector<int> DrawAllOrSome(int num_points, int set_size, std::int64_t count, const Rng& rng) {
  if (Combinations(num_points, set_size) <= count) {
    ExhaustiveSampler all(num_points, set_size);
    return DrawSets(all, set_size, count);
  }
  UniformSampler some(num_points, set_size, rng);
  return DrawSets(some, set_size, count);
}

bool UniformSampler::Next(std::span<int> set) {
  if (set_size_ < 1 || num_points_ < set_size_ || static_cast<int>(set.size()) != set_size_) return false;
  DrawDistinct(num_points_, set_size_, rng_, set.data());
  std::sort(set.begin(), set.end());
  return true;
}

bool ExhaustiveSampler::Next(std::span<int> set) {
  if (set_size_ < 1 || num_points_ < set_size_ || static_cast<int>(set.size()) != set_size_) return false;
  if (last_.empty()) {
    last_.resize(set_size_);
    std::iota(last_.begin(), last_.end(), 0);
  } else if (!Advance(num_points_, &last_)) {
    return false;
  }
  std::copy(last_.begin(), last_.end(), set.begin());
  return true;
}

bool PrecomputedSampler::Next(std::span<int> set) {
  if (set.empty() || rest_.size() < set.size()) return false;
  std::copy_n(rest_.begin(), set.size(), set.begin());
  rest_ = rest_.subspan(set.size());
  return true;
}

void SequenceSampler::Add(std::unique_ptr<MinimalSampler> sampler, std::int64_t count) {
  parts_.push_back({std::move(sampler), count});
}

bool SequenceSampler::Next(std::span<int> set) {
  for (; current_ < parts_.size(); ++current_) {
    Part& part = parts_[current_];
    if (part.drawn == part.count || !part.sampler->Next(set)) continue;
    ++part.drawn;
    return true;
  }
  return false;
}

std::int64_t Combinations(int n, int k) {
  if (k < 0 || n < k) return 0;
  k = std::min(k, n - k);
  std::int64_t result = 1;
  for (int i = 1; i <= k; ++i) {
    const std::int64_t factor = n - k + i;
    if (result > std::numeric_limits<std::int64_t>::max() / factor) return std::numeric_limits<std::int64_t>::max();
    result = result * factor / i;
  }
  return result;
}

int CountUniqueSets(const std::vector<int>& sets, int set_size) {
  if (set_size < 1) return 0;
  const int count = static_cast<int>(sets.size()) / set_size;
  const auto less = [&](int a, int b) {
    const int *left = sets.data() + static_cast<std::size_t>(a) * set_size,
              *right = sets.data() + static_cast<std::size_t>(b) * set_size;
    return std::lexicographical_compare(left, left + set_size, right, right + set_size);
  };
  // The exhaustive sampler's sets are sorted already: one pass shows it and spares the sort.
  int ascending = count > 0 ? 1 : 0;
  while (ascending < count && less(ascending - 1, ascending)) ++ascending;
  if (ascending == count) return count;
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), less);
  int unique = 1;
  for (int i = 1; i < count; ++i) unique += less(order[i - 1], order[i]) ? 1 : 0;
  return unique;
}

std::vector<std::vector<int>> FirstSets(const std::vector<int>& sets, int set_size) {
  std::vector<std::vector<int>> first;
  for (auto begin = sets.begin(); sets.end() - begin >= set_size && first.size() < kReportedSets; begin += set_size)
    first.emplace_back(begin, begin + set_size);
  return first;
}

}  // namespace diffsac
