#include "diffsac/ransac/samplers/prosac_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diffsac {

GrowthFunction::GrowthFunction(int set_size, int num_points, double samples)
    : set_size_(set_size),
      num_points_(num_points),
      total_(std::min(samples, static_cast<double>(Combinations(num_points, set_size)))),
      last_(Average(set_size)),
      limits_{1} {}

double GrowthFunction::Average(int n) const {
  // From the definition for each n: the recurrence T_(n+1) = T_n (n+1)/(n+1−m) would gather rounding errors, which the
  // ceiling turns into whole draws.
  double value = total_;
  for (int i = 0; i < set_size_; ++i) value *= static_cast<double>(n - i) / (num_points_ - i);
  return value;
}

int GrowthFunction::SubsetSize(std::int64_t t) {
  constexpr double kRounding = 1e-9;
  const int last = num_points_ - set_size_;
  while (limits_.back() < t && static_cast<int>(limits_.size()) <= last) {
    const double next = Average(set_size_ + static_cast<int>(limits_.size()));
    limits_.push_back(limits_.back() + static_cast<std::int64_t>(std::ceil((next - last_) * (1.0 - kRounding))));
    last_ = next;
  }
  const auto place = std::lower_bound(limits_.begin(), limits_.end(), t);
  return set_size_ + static_cast<int>(place - limits_.begin());
}

QualityOrder::QualityOrder(std::span<const double> quality) {
  points_.reserve(quality.size());
  for (const double value : quality)
    points_.emplace_back(std::isfinite(value) ? value : std::numeric_limits<double>::max(), size());
}

int QualityOrder::operator[](int place) {
  constexpr int kFirst = 128;
  if (place >= sorted_) {
    const int end = std::min(size(), std::max({place + 1, 2 * sorted_, kFirst}));
    const auto begin = points_.begin() + sorted_;
    if (end < size()) std::nth_element(begin, points_.begin() + end, points_.end());
    std::sort(begin, points_.begin() + end);
    sorted_ = end;
  }
  return points_[place].second;
}

std::vector<int> OrderByQuality(std::span<const double> quality) {
  QualityOrder order(quality);
  std::vector<int> points(quality.size());
  for (int place = order.size() - 1; place >= 0; --place) points[place] = order[place];
  return points;
}

ProsacSampler::ProsacSampler(std::span<const double> quality, int set_size, const Rng& rng, double samples,
                             std::int64_t first_draw)
    : set_size_(set_size), rng_(rng), draws_(first_draw), order_(quality) {
  const int num_points = order_.size();
  if (set_size >= 1 && num_points >= set_size) growth_.emplace_back(set_size, num_points, samples);
}

bool ProsacSampler::Next(std::span<int> set) {
  if (growth_.empty() || static_cast<int>(set.size()) != set_size_) return false;
  const int num_points = order_.size();
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
