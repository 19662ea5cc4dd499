#pragma once

#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include "lab/torch/point_block.h"

namespace diffsac {

/// A residual edge convolution over the k nearest points in the space of the layer's own features, so that the graph
/// changes from layer to layer (Wang et al., "Dynamic graph CNN for learning on point clouds", ACM TOG 2019):
///
///   x_i + B max_{j ∈ kNN(i)} lrelu(A u_i + C (u_j − u_i)),  u = norm(x),
///
/// A and C to twice the width, lrelu with slope 0.2. A point counts among its own neighbours. Quadratic in N.
class EdgeBlock : public PointBlock {
 public:
  EdgeBlock(std::int64_t width, std::int64_t neighbors, Rng rng);
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask) override;

 private:
  std::int64_t neighbors_;
  torch::nn::LayerNorm norm_{nullptr};
  torch::nn::Linear own_{nullptr};
  torch::nn::Linear difference_{nullptr};
  torch::nn::Linear output_{nullptr};
};

/// The k nearest rows of each row of u [S, N, W], itself included: indices [S, N, min(k, N)]. Padded rows are
/// neighbours only where fewer than k are real, and then stand last.
torch::Tensor NearestRows(const torch::Tensor& u, const torch::Tensor& mask, std::int64_t k);

}  // namespace diffsac
