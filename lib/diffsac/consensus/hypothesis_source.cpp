#include "diffsac/consensus/hypothesis_source.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace diffsac {
namespace {

/// Advances an ascending set to its lexicographic successor; false after the last.
bool NextSet(int n, int size, int* set) {
  int position = size - 1;
  while (position >= 0 && set[position] == n - size + position) --position;
  if (position < 0) return false;
  ++set[position];
  for (int i = position + 1; i < size; ++i) set[i] = set[i - 1] + 1;
  return true;
}

/// The set at `rank` in lexicographic order: each member in turn is moved up past the sets that start lower.
void SetOfRank(int n, int size, std::int64_t rank, int* set) {
  int value = 0;
  for (int position = 0; position < size; ++position, ++value) {
    for (std::int64_t block; rank >= (block = Combinations(n - value - 1, size - position - 1)); ++value) rank -= block;
    set[position] = value;
  }
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

int UniformSource::DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                             std::vector<int>* sets) const {
  if (set_size < 1 || num_points < set_size || count < 1) return 0;
  std::vector<int> set(set_size);
  for (int i = 0; i < count; ++i) {
    Rng draw = DrawRng(rng, first + i);
    DrawDistinct(num_points, set_size, draw, set.data());
    std::sort(set.begin(), set.end());
    sets->insert(sets->end(), set.begin(), set.end());
  }
  return count;
}

int UniformSource::Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const {
  if (set_size < 1 || num_points < set_size || count < 1) return 0;
  const std::size_t start = sets->size();
  sets->resize(start + static_cast<std::size_t>(count) * set_size);
  int* set = sets->data() + start;
  for (int i = 0; i < count; ++i, set += set_size) {
    DrawDistinct(num_points, set_size, rng, set);
    std::sort(set, set + set_size);
  }
  return count;
}

int ExhaustiveSource::Draw(int num_points, int set_size, int /*count*/, Rng /*rng*/, std::vector<int>* sets) const {
  if (set_size < 1 || num_points < set_size) return 0;
  sets->reserve(sets->size() + static_cast<std::size_t>(Combinations(num_points, set_size)) * set_size);
  std::vector<int> set(set_size);
  std::iota(set.begin(), set.end(), 0);
  int given = 0;
  do {
    sets->insert(sets->end(), set.begin(), set.end());
    ++given;
  } while (NextSet(num_points, set_size, set.data()));
  return given;
}

int ExhaustiveSource::DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& /*rng*/,
                                std::vector<int>* sets) const {
  if (set_size < 1 || count < 1 || first < 0 || first >= Combinations(num_points, set_size)) return 0;
  std::vector<int> set(set_size);
  SetOfRank(num_points, set_size, first, set.data());
  int given = 0;
  do {
    sets->insert(sets->end(), set.begin(), set.end());
    ++given;
  } while (given < count && NextSet(num_points, set_size, set.data()));
  return given;
}

int GivenSource::DrawBlock(int /*num_points*/, int set_size, std::int64_t first, int count, const Rng& /*rng*/,
                           std::vector<int>* sets) const {
  if (set_size < 1 || count < 1 || first < 0) return 0;
  const std::int64_t available = static_cast<std::int64_t>(sets_.size()) / set_size - first;
  const int given = static_cast<int>(std::clamp<std::int64_t>(available, 0, count));
  const auto begin = sets_.begin() + (given > 0 ? first * set_size : 0);
  sets->insert(sets->end(), begin, begin + static_cast<std::int64_t>(given) * set_size);
  return given;
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
  // The exhaustive source's sets are sorted already: one pass shows it and spares the sort.
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

}  // namespace diffsac
