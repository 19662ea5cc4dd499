#include "diffsac/consensus/prosac_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace diffsac {

GrowthFunction::GrowthFunction(int set_size, int num_points, double samples) : set_size_(set_size) {
  const double all_sets = static_cast<double>(Combinations(num_points, set_size));
  // T_n from the definition for each n: the recurrence T_(n+1) = T_n (n+1)/(n+1−m) would gather rounding errors, which
  // the ceiling turns into whole draws.
  const auto average = [&, total = std::min(samples, all_sets)](int n) {
    double value = total;
    for (int i = 0; i < set_size; ++i) value *= static_cast<double>(n - i) / (num_points - i);
    return value;
  };
  constexpr double kRounding = 1e-9;
  limits_.reserve(num_points - set_size + 1);
  limits_.push_back(1);
  double last = average(set_size);
  for (int n = set_size + 1; n <= num_points; ++n) {
    const double next = average(n);
    limits_.push_back(limits_.back() + static_cast<std::int64_t>(std::ceil((next - last) * (1.0 - kRounding))));
    last = next;
  }
}

int GrowthFunction::SubsetSize(std::int64_t t) const {
  const auto place = std::lower_bound(limits_.begin(), limits_.end(), t);
  return set_size_ + static_cast<int>(place - limits_.begin());
}

std::vector<int> OrderByQuality(std::span<const double> quality) {
  const auto key = [&](int i) { return std::isfinite(quality[i]) ? quality[i] : std::numeric_limits<double>::max(); };
  std::vector<int> order(quality.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  return order;
}

ProsacSource::ProsacSource(std::span<const double> quality, int set_size, const Rng& rng, double samples,
                           std::int64_t first_draw)
    : set_size_(set_size), rng_(rng), draws_(first_draw), order_(OrderByQuality(quality)) {
  const int num_points = static_cast<int>(order_.size());
  if (set_size >= 1 && num_points >= set_size) growth_.emplace_back(set_size, num_points, samples);
}

bool ProsacSource::Next(std::span<int> set) {
  if (growth_.empty() || static_cast<int>(set.size()) != set_size_) return false;
  const int num_points = static_cast<int>(order_.size());
  Rng draw = DrawRng(rng_, draws_);
  const int subset = growth_[0].SubsetSize(++draws_);
  if (subset > num_points) {
    DrawDistinct(num_points, set_size_, draw, set.data());
  } else {
    DrawDistinct(subset - 1, set_size_ - 1, draw, set.data());
    set.back() = subset - 1;
  }
  for (int& rank : set) rank = order_[rank];
  std::sort(set.begin(), set.end());
  return true;
}

}  // namespace diffsac
