#include "lab/torch/point_batch.h"

#include <torch/torch.h>

#include <algorithm>
#include <cstring>

namespace diffsac {

PointBatch PointBatch::To(const torch::Device& device) const {
  return {features.to(device), mask.defined() ? mask.to(device) : mask, lengths};
}

PointBatch MakePointBatch(std::span<const FeatureSet* const> sets) {
  PointBatch batch;
  std::int64_t longest = 0;
  bool ragged = false;
  for (const FeatureSet* set : sets) {
    batch.lengths.push_back(set->values.rows());
    longest = std::max<std::int64_t>(longest, set->values.rows());
    ragged = ragged || set->values.rows() != sets[0]->values.rows();
  }
  const std::int64_t count = static_cast<std::int64_t>(sets.size());
  const std::int64_t width = sets[0]->values.cols();
  batch.features = ragged ? torch::zeros({count, longest, width}) : torch::empty({count, longest, width});
  float* out = batch.features.data_ptr<float>();
  for (std::int64_t b = 0; b < count; ++b) {
    TORCH_CHECK(sets[b]->values.cols() == width, "feature sets of different widths in one batch");
    std::memcpy(out + b * longest * width, sets[b]->values.data(), sizeof(float) * sets[b]->values.size());
  }
  if (ragged) {
    batch.mask = torch::zeros({count, longest}, torch::kBool);
    for (std::int64_t b = 0; b < count; ++b) batch.mask[b].slice(0, 0, batch.lengths[b]).fill_(true);
  }
  return batch;
}

}  // namespace diffsac
