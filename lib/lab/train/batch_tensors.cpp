#include "lab/train/batch_tensors.h"

#include <torch/torch.h>

#include <algorithm>

namespace diffsac {

PointBatch CollatePoints(const std::vector<TrainingItem>& items) {
  std::vector<const FeatureSet*> sets;
  for (const auto& item : items) sets.push_back(&item.features);
  return MakePointBatch(sets);
}

torch::Tensor PadRows(const std::vector<std::vector<float>>& rows, std::int64_t points, float padding) {
  auto tensor = torch::full({static_cast<std::int64_t>(rows.size()), points}, padding);
  for (std::size_t b = 0; b < rows.size(); ++b)
    std::copy(rows[b].begin(), rows[b].end(), tensor.data_ptr<float>() + static_cast<std::int64_t>(b) * points);
  return tensor;
}

}  // namespace diffsac
