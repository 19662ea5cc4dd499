#pragma once

#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include <memory>
#include <vector>

#include "diffsac/denoiser/denoiser.h"

namespace diffsac {

/// A residual point-wise layer that also sees its set: mean, maximum and a learned softmax pooling of the points
/// (Zaheer et al., "Deep sets", 2017; Lee et al., "Set transformer", 2019). Linear in N.
class PooledBlock : public torch::nn::Module {
 public:
  PooledBlock(std::int64_t width, Rng rng);
  /// x: [S, N, W]; mask: [S, N] bool or undefined.
  torch::Tensor Forward(const torch::Tensor& x, const torch::Tensor& mask);

 private:
  torch::Tensor Pool(const torch::Tensor& u, const torch::Tensor& mask);

  torch::nn::LayerNorm norm_{nullptr};
  torch::nn::Linear attention_{nullptr};
  torch::nn::Linear set_{nullptr};
  torch::nn::Linear point_{nullptr};
  torch::nn::Linear output_{nullptr};
};

/// A denoiser for CPUs: point-wise layers with pooled context instead of attention between all pairs of points, the
/// encoder shared by all copies and steps. Same inputs and outputs as the paper's network.
class PooledDenoiser : public Denoiser {
 public:
  PooledDenoiser(const DenoiserOptions& options, int input_width, Rng rng);
  Context Encode(const PointBatch& batch) override;
  torch::Tensor Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t,
                        const torch::Tensor& previous) override;

 private:
  DenoiserOptions options_;
  torch::nn::Linear input_points_{nullptr};
  std::vector<std::shared_ptr<PooledBlock>> encoder_;
  torch::nn::LayerNorm ln_encoder_{nullptr};
  torch::nn::Linear inlier_proj_{nullptr};
  torch::nn::Linear input_confidence_{nullptr};
  torch::nn::Linear time_hidden_{nullptr};
  torch::nn::Linear time_output_{nullptr};
  std::vector<std::shared_ptr<PooledBlock>> decoder_;
  torch::nn::LayerNorm ln_post_{nullptr};
  torch::nn::Linear output_proj_{nullptr};
};

}  // namespace diffsac
