#include "diffsac/consensus/napsac_source.h"

#include <algorithm>

namespace diffsac {

int NapsacSource::DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                            std::vector<int>* sets) const {
  if (set_size < 1 || num_points < set_size || num_points != index_.size()) return 0;
  std::vector<int> set(set_size), ranks(set_size);
  for (int i = 0; i < count; ++i) {
    Rng draw = DrawRng(rng, first + i);
    set[0] = static_cast<int>(draw.Below(static_cast<std::uint64_t>(num_points)));
    const std::vector<int> near = index_.Nearest(set[0], std::max(neighbors_, set_size - 1));
    DrawDistinct(static_cast<int>(near.size()), set_size - 1, draw, ranks.data());
    for (int member = 1; member < set_size; ++member) set[member] = near[ranks[member - 1]];
    std::sort(set.begin(), set.end());
    sets->insert(sets->end(), set.begin(), set.end());
  }
  return std::max(count, 0);
}

ProgressiveNapsacSource::ProgressiveNapsacSource(const PointMatrix& points, std::span<const double> quality,
                                                 int set_size, int local_draws)
    : index_(points),
      set_size_(set_size),
      local_draws_(std::int64_t{local_draws} * points.rows()),
      prosac_(quality, set_size) {
  const int num_points = index_.size();
  if (set_size < 1 || num_points < set_size) return;
  const double samples = static_cast<double>(local_draws_);
  if (!quality.empty()) {
    order_ = OrderByQuality(quality);
    global_.emplace_back(set_size, num_points, samples);
  }
  if (set_size > 1) local_.emplace_back(set_size - 1, num_points - 1, samples);
}

int ProgressiveNapsacSource::FirstPoint(std::int64_t index, Rng& draw) const {
  const int num_points = index_.size();
  if (order_.empty()) return static_cast<int>(draw.Below(static_cast<std::uint64_t>(num_points)));
  const int subset = std::min(global_[0].SubsetSize(index + 1), num_points);
  return order_[draw.Below(static_cast<std::uint64_t>(subset))];
}

void ProgressiveNapsacSource::DrawAround(int center, std::int64_t hits, Rng& draw, int* set) const {
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

int ProgressiveNapsacSource::DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                                       std::vector<int>* sets) const {
  if (set_size < 1 || set_size != set_size_ || num_points < set_size || num_points != index_.size()) return 0;
  if (!order_.empty() && static_cast<int>(order_.size()) != num_points) return 0;
  const int local = static_cast<int>(std::clamp<std::int64_t>(local_draws_ - first, 0, std::max(count, 0)));
  // How often each point came first before this block: its draws are made again, which keeps the source stateless.
  std::vector<std::int64_t> hits(local > 0 ? num_points : 0, 0);
  for (std::int64_t index = 0; local > 0 && index < first; ++index) {
    Rng draw = DrawRng(rng, index);
    ++hits[FirstPoint(index, draw)];
  }
  std::vector<int> set(set_size);
  for (int i = 0; i < local; ++i) {
    Rng draw = DrawRng(rng, first + i);
    const int center = FirstPoint(first + i, draw);
    DrawAround(center, ++hits[center], draw, set.data());
    std::sort(set.begin(), set.end());
    sets->insert(sets->end(), set.begin(), set.end());
  }
  const int global = std::max(count, 0) - local;
  if (order_.empty()) return local + UniformSource().DrawBlock(num_points, set_size, first + local, global, rng, sets);
  // PROSAC starts where its growth function would be had it drawn all along.
  return local + prosac_.DrawBlock(num_points, set_size, first + local, global, rng, sets);
}

}  // namespace diffsac
