#pragma once

#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include <memory>
#include <vector>

#include "diffsac/denoiser/denoiser.h"
#include "diffsac/denoiser/point_block.h"

namespace diffsac {

/// Blocks over the points before and after c_t enters, the encoder shared by all copies and steps; which blocks, the
/// options' `kind` says. Same inputs and outputs as the paper's network.
class BlockDenoiser : public Denoiser {
 public:
  BlockDenoiser(const DenoiserOptions& options, int input_width, Rng rng);
  Context Encode(const PointBatch& batch) override;
  torch::Tensor Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t,
                        const torch::Tensor& previous) override;

 private:
  DenoiserOptions options_;
  torch::nn::Linear input_points_{nullptr};
  std::vector<std::shared_ptr<PointBlock>> encoder_;
  torch::nn::LayerNorm ln_encoder_{nullptr};
  torch::nn::Linear inlier_proj_{nullptr};
  torch::nn::Linear input_confidence_{nullptr};
  torch::nn::Linear time_hidden_{nullptr};
  torch::nn::Linear time_output_{nullptr};
  std::vector<std::shared_ptr<PointBlock>> decoder_;
  torch::nn::LayerNorm ln_post_{nullptr};
  torch::nn::Linear output_proj_{nullptr};
};

}  // namespace diffsac
