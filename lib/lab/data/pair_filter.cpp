#include "lab/data/pair_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diffsac/core/random.h"

namespace diffsac {
namespace {

std::vector<int> Permuted(const std::vector<int>& values, Rng rng) {
  std::vector<int> permuted;
  for (int i : rng.Permutation(static_cast<int>(values.size()))) permuted.push_back(values[i]);
  return permuted;
}

// Each image's descriptor of each match by itself.
void AddDescriptorNoise(double strength, Rng rng, DescriptorMatrix* descriptors) {
  const Eigen::Index size = descriptors->cols() / 2;
  for (Eigen::Index i = 0; i < descriptors->rows(); ++i)
    for (int image = 0; image < 2; ++image) {
      auto values = descriptors->row(i).segment(image * size, size);
      const double deviation = strength * values.norm() / std::sqrt(static_cast<double>(size));
      for (float& value : values) value += static_cast<float>(deviation * rng.Normal());
    }
}

// Values of each point; unknown ones stay empty.
template <class Value>
void TakeRows(const std::vector<int>& rows, Eigen::Index count, std::vector<Value>* values) {
  if (static_cast<Eigen::Index>(values->size()) != count) return;
  std::vector<Value> taken;
  taken.reserve(rows.size());
  for (const int row : rows) taken.push_back((*values)[row]);
  *values = std::move(taken);
}

}  // namespace

std::vector<int> KeptRows(const Example& pair, const PairFilter& filter) {
  const Problem& problem = pair.problem;
  const Rng rng = Rng(0).Fork("matches/" + pair.id);
  const bool rated = filter.ratios && problem.snn_ratio.size() == problem.points.rows();
  std::vector<int> rows;
  for (int i = 0; i < problem.points.rows(); ++i)
    if (!rated || !(problem.snn_ratio[i] > filter.max_ratio)) rows.push_back(i);
  if (filter.max_points > 0 && static_cast<int>(rows.size()) > filter.max_points) {
    if (filter.cap == PointCap::kRandom)
      rows = Permuted(rows, rng.Fork("cap"));
    else if (rated)
      std::stable_sort(rows.begin(), rows.end(),
                       [&](int a, int b) { return problem.snn_ratio[a] < problem.snn_ratio[b]; });
    rows.resize(filter.max_points);
    std::sort(rows.begin(), rows.end());
  }
  return filter.shuffle_points ? Permuted(rows, rng.Fork("shuffle")) : rows;
}

Example Filtered(const Example& pair, const PairFilter& filter) {
  Example example = WithRows(pair, KeptRows(pair, filter));
  if (!filter.ratios) example.problem.snn_ratio.resize(0);
  if (!filter.scale_rotation_changes) example.problem.scale_rotation_changes.resize(0, 2);
  if (filter.descriptor_noise > 0.0)
    AddDescriptorNoise(filter.descriptor_noise, Rng(0).Fork("descriptors/" + pair.id), &example.problem.descriptors);
  return example;
}

Example WithRows(const Example& example, const std::vector<int>& rows) {
  const Problem& all = example.problem;
  const Eigen::Index count = all.points.rows();
  Example part = example;
  part.problem.points = all.points(rows, Eigen::all);
  if (all.snn_ratio.size() == count) part.problem.snn_ratio = all.snn_ratio(rows);
  if (all.scale_rotation_changes.rows() == count)
    part.problem.scale_rotation_changes = all.scale_rotation_changes(rows, Eigen::all);
  if (all.descriptors.rows() == count) part.problem.descriptors = all.descriptors(rows, Eigen::all);
  TakeRows(rows, count, &part.truth.inliers);
  TakeRows(rows, count, &part.truth.assignment);
  return part;
}

}  // namespace diffsac
