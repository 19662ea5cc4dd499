#include "lab/data/generator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "diffsac/core/status.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {

void GeneratorOptions::BindStream(OptionsBinder& b, const char* help) {
  b.Field("size", size, AtLeast(-1)).Help("examples; -1 is endless");
  b.Field("split", split).Help(help);
}

Example GeneratedDataset::Get(std::uint64_t index) const {
  if (size_ >= 0 && index >= static_cast<std::uint64_t>(size_))
    throw std::out_of_range("example " + std::to_string(index) + " of a dataset of " + std::to_string(size_));
  Example example = Draw(index, root_.Fork("example", index));
  example.index = index;
  example.id = ids_ + std::to_string(index) + example.id;
  example.scene = "all";
  return example;
}

int DrawWhole(const Range& range, Rng& rng) {
  const auto low = static_cast<int>(range.low), high = static_cast<int>(range.high);
  return low + static_cast<int>(rng.Below(high - low + 1));
}

bool IsWhole(const Range& range) { return std::floor(range.low) == range.low && std::floor(range.high) == range.high; }

PointCounts DrawCounts(const Range& num_points, const Range& outlier_ratio, Task task, Rng rng) {
  const int total = DrawWhole(num_points, rng);
  const double ratio = rng.Uniform(outlier_ratio.low, outlier_ratio.high);
  const int inliers = static_cast<int>(std::lround(total * (1.0 - ratio)));
  return {total, std::clamp(inliers, MinimalSetSize(task) + 1, total)};
}

void CheckCounts(const Range& num_points, Task task) {
  const int least = MinimalSetSize(task) + 1;
  if (num_points.low < least)
    throw Error("num_points: expected at least " + std::to_string(least) + " for the task " + ToString(task));
}

}  // namespace diffsac
