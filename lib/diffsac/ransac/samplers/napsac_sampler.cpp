#include "diffsac/ransac/samplers/napsac_sampler.h"

#include <algorithm>

namespace diffsac {

bool NapsacSampler::Next(std::span<int> set) {
  const int num_points = index_.size();
  if (set_size_ < 1 || num_points < set_size_ || static_cast<int>(set.size()) != set_size_) return false;
  Rng draw = DrawRng(rng_, draws_++);
  set[0] = static_cast<int>(draw.Below(static_cast<std::uint64_t>(num_points)));
  const std::vector<int> near = index_.Nearest(set[0], std::max(neighbors_, set_size_ - 1));
  DrawDistinct(static_cast<int>(near.size()), set_size_ - 1, draw, set.data() + 1);
  for (int member = 1; member < set_size_; ++member) set[member] = near[set[member]];
  std::sort(set.begin(), set.end());
  return true;
}

ProgressiveNapsacSampler::ProgressiveNapsacSampler(const PointMatrix& points, std::span<const double> quality,
                                                   int set_size, const Rng& rng, int local_draws)
    : index_(points),
      set_size_(set_size),
      rng_(rng),
      local_draws_(std::int64_t{local_draws} * points.rows()),
      hits_(points.rows(), 0) {
  const int num_points = index_.size();
  if (quality.empty()) {
    global_sampler_ = std::make_unique<UniformSampler>(num_points, set_size, rng.Fork("global"));
  } else {
    // PROSAC starts where its growth function would be had it drawn all along.
    global_sampler_ = std::make_unique<ProsacSampler>(quality, set_size, rng, ProsacSampler::kSamples, local_draws_);
  }
  if (set_size < 1 || num_points < set_size) return;
  const double samples = static_cast<double>(local_draws_);
  if (!quality.empty()) {
    order_ = OrderByQuality(quality);
    global_.emplace_back(set_size, num_points, samples);
  }
  if (set_size > 1) local_.emplace_back(set_size - 1, num_points - 1, samples);
}

int ProgressiveNapsacSampler::FirstPoint(Rng& draw) {
  const int num_points = index_.size();
  if (order_.empty()) return static_cast<int>(draw.Below(static_cast<std::uint64_t>(num_points)));
  const int subset = std::min(global_[0].SubsetSize(draws_ + 1), num_points);
  return order_[draw.Below(static_cast<std::uint64_t>(subset))];
}

void ProgressiveNapsacSampler::DrawAround(int center, std::int64_t hits, Rng& draw, int* set) {
  set[0] = center;
  const int others = set_size_ - 1;
  if (others == 0) return;
  const int available = index_.size() - 1;
  const int nearest = local_[0].SubsetSize(hits);
  const std::vector<int> near = index_.Nearest(center, std::min(nearest, available));
  if (nearest > available) {
    DrawDistinct(available, others, draw, set + 1);
  } else {
    DrawDistinct(nearest - 1, others - 1, draw, set + 1);
    set[others] = nearest - 1;
  }
  for (int i = 1; i <= others; ++i) set[i] = near[set[i]];
}

bool ProgressiveNapsacSampler::Next(std::span<int> set) {
  const int num_points = index_.size();
  if (set_size_ < 1 || static_cast<int>(set.size()) != set_size_ || num_points < set_size_) return false;
  if (!order_.empty() && static_cast<int>(order_.size()) != num_points) return false;
  if (draws_ >= local_draws_) return global_sampler_->Next(set);
  Rng draw = DrawRng(rng_, draws_);
  const int center = FirstPoint(draw);
  DrawAround(center, ++hits_[center], draw, set.data());
  std::sort(set.begin(), set.end());
  ++draws_;
  return true;
}

}  // namespace diffsac
