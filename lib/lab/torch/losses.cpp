#include "lab/torch/losses.h"

#include <torch/torch.h>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

torch::Tensor ElementLoss(DiffusionLossKind kind, const torch::Tensor& prediction, const torch::Tensor& c0) {
  if (kind == DiffusionLossKind::kMse) return (prediction - c0).square();
  const auto target = (c0 > 0).to(prediction.scalar_type());
  return torch::binary_cross_entropy_with_logits(prediction, target, {}, {}, torch::Reduction::None);
}

}  // namespace

torch::Tensor DiffusionLoss(DiffusionLossKind kind, const torch::Tensor& prediction, const torch::Tensor& c0,
                            const torch::Tensor& mask, double positive_weight) {
  if (!(positive_weight > 0.0)) throw Error("loss: positive_weight must be positive");
  if (prediction.sizes() != c0.sizes()) throw Error("loss: prediction and labels differ in shape");

  const bool reduced = prediction.scalar_type() == torch::kHalf || prediction.scalar_type() == torch::kBFloat16;
  auto values = reduced ? prediction.to(torch::kFloat32) : prediction;
  auto labels = c0.to(values.scalar_type());
  auto weights = torch::ones_like(labels);
  if (positive_weight != 1.0) weights = torch::where(labels > 0, weights * positive_weight, weights);
  if (mask.defined()) {
    // Before the loss, not after: 0 times NaN would reach the gradient.
    const auto dropped = mask.to(torch::kBool).logical_not();
    values = values.masked_fill(dropped, 0.0);
    labels = labels.masked_fill(dropped, 0.0);
    weights = weights.masked_fill(dropped, 0.0);
  }
  const auto total = (weights * ElementLoss(kind, values, labels)).sum();
  const auto weight = weights.sum();
  return total / torch::where(weight > 0, weight, torch::ones_like(weight));
}

torch::Tensor LogitsToConfidence(const torch::Tensor& logits) { return 2.0 * torch::sigmoid(logits) - 1.0; }

}  // namespace diffsac
