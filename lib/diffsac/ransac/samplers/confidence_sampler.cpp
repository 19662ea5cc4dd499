#include "diffsac/ransac/samplers/confidence_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace diffsac {
namespace {

/// Attempts at a fresh probabilistic draw before a taken set is replaced by its best neighbour.
constexpr int kRedraws = 8;
/// Sets looked at by one copy before it gives none.
constexpr int kMaxLooks = 4096;

using Set = std::vector<int>;

/// Point indices by falling key; the lower index first where keys tie.
std::vector<int> OrderByKey(const std::vector<double>& keys) {
  std::vector<int> order(keys.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return keys[a] > keys[b]; });
  return order;
}

Set SetOfRanks(const std::vector<int>& order, const std::vector<int>& ranks) {
  Set set(ranks.size());
  for (std::size_t i = 0; i < ranks.size(); ++i) set[i] = order[ranks[i]];
  std::sort(set.begin(), set.end());
  return set;
}

/// The best set that is not in `taken`: the first γ ranks, then the worst member replaced by each later rank in order,
/// then all sets by rising sum of ranks. Empty when there is none within kMaxLooks.
Set BestNewSet(const std::vector<int>& order, int set_size, const std::set<Set>& taken) {
  const int n = static_cast<int>(order.size());
  std::vector<int> ranks(set_size);
  std::iota(ranks.begin(), ranks.end(), 0);
  const std::vector<int> first = ranks;
  int looks = 0;
  for (; ranks.back() < n && looks < kMaxLooks; ++ranks.back(), ++looks) {
    Set set = SetOfRanks(order, ranks);
    if (!taken.contains(set)) return set;
  }
  using Entry = std::pair<int, std::vector<int>>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  std::set<std::vector<int>> seen{first};
  open.push({0, first});
  for (; !open.empty() && looks < kMaxLooks; ++looks) {
    const auto [sum, current] = open.top();
    open.pop();
    Set set = SetOfRanks(order, current);
    if (!taken.contains(set)) return set;
    for (int i = 0; i < set_size; ++i) {
      std::vector<int> next = current;
      if (++next[i] >= (i + 1 < set_size ? current[i + 1] : n)) continue;
      if (seen.insert(next).second) open.push({sum + 1, std::move(next)});
    }
  }
  return {};
}

/// One copy's keys: the confidences themselves, or with Gumbel noise, whose top γ are a draw without replacement.
std::vector<double> Keys(std::span<const float> copy, Selection selection, double temperature, Rng& rng) {
  std::vector<double> keys(copy.size());
  for (std::size_t i = 0; i < copy.size(); ++i) {
    double noise = 0.0;
    if (selection == Selection::kProbabilistic) {
      // 1 - U lies in (0, 1]; the smallest positive number keeps the inner logarithm from 0.
      const double exponential = std::max(-std::log(1.0 - rng.Uniform()), std::numeric_limits<double>::min());
      noise = -std::log(exponential);
    }
    const double scale = selection == Selection::kProbabilistic ? temperature : 1.0;
    keys[i] = std::isfinite(copy[i]) ? copy[i] / scale + noise : -std::numeric_limits<double>::infinity();
  }
  return keys;
}

}  // namespace

ConfidenceSampler::ConfidenceSampler(std::span<const float> confidences, int num_points, int set_size,
                                     Selection selection, bool unique, double temperature, const Rng& rng)
    : confidences_(confidences),
      num_points_(num_points),
      set_size_(set_size),
      selection_(selection),
      unique_(unique),
      temperature_(std::max(temperature, 1e-6)),
      rng_(rng),
      copies_(num_points > 0 ? static_cast<int>(confidences.size() / static_cast<std::size_t>(num_points)) : 0) {}

ConfidenceSampler::Set ConfidenceSampler::FromCopy(std::span<const float> copy, Rng& rng) {
  const auto first_ranks = [&](const std::vector<int>& order) {
    Set set(order.begin(), order.begin() + set_size_);
    std::sort(set.begin(), set.end());
    return set;
  };
  std::vector<int> order = OrderByKey(Keys(copy, selection_, temperature_, rng));
  Set set = first_ranks(order);
  if (!unique_) return set;
  for (int i = 0; selection_ == Selection::kProbabilistic && i < kRedraws && taken_.contains(set); ++i) {
    order = OrderByKey(Keys(copy, selection_, temperature_, rng));
    set = first_ranks(order);
  }
  return taken_.contains(set) ? BestNewSet(order, set_size_, taken_) : set;
}

bool ConfidenceSampler::Next(std::span<int> out) {
  if (set_size_ < 1 || num_points_ < set_size_ || static_cast<int>(out.size()) != set_size_) return false;
  const bool repeats_itself = selection_ == Selection::kMaximum && !unique_;
  while (fruitless_ < copies_ && !(repeats_itself && draws_ >= copies_)) {
    const std::size_t row = static_cast<std::size_t>(draws_ % copies_) * static_cast<std::size_t>(num_points_);
    Rng rng = rng_.Fork("copy", static_cast<std::uint64_t>(draws_++));
    const Set set = FromCopy(confidences_.subspan(row, num_points_), rng);
    if (set.empty()) {
      ++fruitless_;
      continue;
    }
    fruitless_ = 0;
    if (unique_) taken_.insert(set);
    std::copy(set.begin(), set.end(), out.begin());
    return true;
  }
  return false;
}

}  // namespace diffsac
