#pragma once

#include <torch/types.h>

#include <span>
#include <vector>

#include "lab/torch/point_batch.h"
#include "lab/train/training_source.h"

namespace diffsac {

/// The features of a training batch.
PointBatch CollatePoints(const std::vector<TrainingItem>& items);

/// Rows of the points' lengths, padded with `padding` to [B, N].
torch::Tensor PadRows(const std::vector<std::vector<float>>& rows, std::int64_t points, float padding);

}  // namespace diffsac
