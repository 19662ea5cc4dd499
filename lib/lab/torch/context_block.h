#pragma once

#include <torch/nn/module.h>
#include <torch/nn/modules/linear.h>

#include "diffsac/core/random.h"

namespace diffsac {

/// Each point's share in its problem's means, [B, 1, N]: 1/length for real points, 0 for padding.
torch::Tensor MeanShares(const torch::Tensor& mask, std::int64_t batch, std::int64_t points,
                         const torch::TensorOptions& options);

/// Context normalisation (Moo Yi et al., "Learning to find good correspondences", CVPR 2018; instance normalisation
/// over the points of a problem): each channel to mean 0 and variance 1 over the real points, then a learned scale and
/// shift for each channel, then a ReLU. All that a point learns of the others goes through these two moments.
class ContextNorm : public torch::nn::Module {
 public:
  explicit ContextNorm(std::int64_t channels);
  /// x: [B, N, C]; shares: of MeanShares.
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& shares);

 private:
  torch::Tensor gain_;
  torch::Tensor shift_;
};

/// x += relu(norm(linear(relu(norm(linear(x)))))).
class ContextBlock : public torch::nn::Module {
 public:
  ContextBlock(std::int64_t width, Rng rng);
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& shares);

 private:
  torch::nn::Linear first_{nullptr};
  std::shared_ptr<ContextNorm> first_norm_;
  torch::nn::Linear second_{nullptr};
  std::shared_ptr<ContextNorm> second_norm_;
};

}  // namespace diffsac
