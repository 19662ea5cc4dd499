#include "lab/torch/point_relation.h"

#include <torch/torch.h>

#include <cmath>

#include "diffsac/problem/residual_features.h"

namespace diffsac {
namespace {

constexpr double kFlat = 2.0, kSharp = 8.0;  // sharpnesses before training
constexpr double kLeastLength = 1e-6;        // of a vector that has a direction

torch::Tensor Unit(const torch::Tensor& vectors) {
  return vectors / vectors.norm(2, {-1}, true).clamp_min(kLeastLength);
}

}  // namespace

PointRelation::PointRelation() {
  log_sharpness_ = register_parameter("log_sharpness", torch::tensor({std::log(kFlat), std::log(kSharp)}));
}

torch::Tensor PointRelation::Agreements(const torch::Tensor& features, int first) {
  using torch::indexing::None;
  using torch::indexing::Slice;
  return Unit(features.index({Slice(), Slice(), Slice(first, None, kColumnsPerHypothesis)}).to(torch::kFloat));
}

std::vector<torch::Tensor> PointRelation::Forward(const torch::Tensor& agreements, const torch::Tensor& mask,
                                                  const torch::Tensor& c_t) {
  const auto confidences = c_t.to(torch::kFloat);
  const auto sharpness = log_sharpness_.exp();
  std::vector<torch::Tensor> outputs;
  for (int i = 0; i < kOutputs; ++i) {
    auto scores = confidences * sharpness[i];
    if (mask.defined()) scores = scores.masked_fill(mask.logical_not().unsqueeze(1), -1e9);
    const auto pooled = torch::bmm(scores.softmax(-1), agreements.to(scores.dtype()));
    outputs.push_back(torch::bmm(Unit(pooled), agreements.transpose(1, 2).to(scores.dtype())).to(c_t.dtype()));
  }
  return outputs;
}

}  // namespace diffsac
