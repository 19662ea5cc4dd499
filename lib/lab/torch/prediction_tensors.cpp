#include "lab/torch/prediction_tensors.h"

#include <torch/torch.h>

namespace diffsac {

PointBatch BatchOf(std::span<const Prediction> predictions, const torch::Device& device) {
  std::vector<const FeatureSet*> rows;
  for (const auto& prediction : predictions) rows.push_back(&prediction.features);
  return MakePointBatch(rows).To(device);
}

void SplitWeights(const torch::Tensor& rows, const std::vector<std::int64_t>& lengths,
                  std::span<Prediction> predictions) {
  const auto values = rows.to(torch::kCPU, torch::kFloat).contiguous();
  for (std::size_t b = 0; b < predictions.size(); ++b) {
    const float* row = values.data_ptr<float>() + static_cast<std::int64_t>(b) * values.size(1);
    predictions[b].weights.assign(row, row + lengths[b]);
  }
}

}  // namespace diffsac
