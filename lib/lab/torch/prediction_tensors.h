#pragma once

#include <torch/types.h>

#include <cstdint>
#include <span>
#include <vector>

#include "diffsac/estimate/learned_estimator.h"
#include "lab/torch/point_batch.h"

namespace diffsac {

/// The features of a batch's predictions, padded to the longest, on the network's device.
PointBatch BatchOf(std::span<const Prediction> predictions, const torch::Device& device);

/// Row b of a tensor [B, N] on any device, without its padding: predictions[b].weights.
void SplitWeights(const torch::Tensor& rows, const std::vector<std::int64_t>& lengths,
                  std::span<Prediction> predictions);

}  // namespace diffsac
