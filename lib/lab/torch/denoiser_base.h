#pragma once

#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>

#include <functional>
#include <memory>
#include <vector>

#include "lab/torch/denoiser.h"
#include "lab/torch/point_block.h"
#include "lab/torch/point_relation.h"

namespace diffsac {

/// The frame of every denoiser:
///
///   context = norm(encoder(norm(FC(χ)))),   output = FC(norm(decoder(norm(FC(c) + MLP(t) + context)))).
///
/// With `relation` c has behind it what PointRelation says of each point.
///
/// What is left out (a norm, the encoder, the inlier head) is passed by. A network is what its constructor registers
/// here, under the names that its checkpoints have.
class DenoiserBase : public Denoiser {
 public:
  Context Encode(const PointBatch& batch) final;
  torch::Tensor Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t) final;

 protected:
  using Blocks = std::vector<std::shared_ptr<PointBlock>>;

  DenoiserBase(const DenoiserOptions& options, const FeatureColumns& columns) : options_(options), columns_(columns) {}
  /// Registers what FC(c) reads and FC(c) itself: c_t, with the option the relations.
  void AddConfidenceInput(const Rng& rng);
  /// Registers a linear layer that starts from rng.Fork(name), kDefault unless `zero`.
  torch::nn::Linear AddLinear(const char* name, std::int64_t in, std::int64_t out, const Rng& rng, bool zero = false);
  torch::nn::LayerNorm AddNorm(const char* name);
  /// Registers name0, name1, …; make(rng.Fork(name, i)).
  Blocks AddBlocks(const std::string& name, int count, const Rng& rng,
                   const std::function<std::shared_ptr<PointBlock>(Rng)>& make);

  torch::Tensor ConfidenceInput(const Context& context, const torch::Tensor& c_t);

  DenoiserOptions options_;
  FeatureColumns columns_;
  std::shared_ptr<PointRelation> relation_;
  torch::nn::Linear input_points_{nullptr};
  torch::nn::Linear input_confidence_{nullptr};
  std::function<torch::Tensor(const torch::Tensor&)> time_mlp_;  ///< of the embedding of t
  torch::nn::LayerNorm ln_encoder_pre_{nullptr};
  Blocks encoder_;
  torch::nn::LayerNorm ln_encoder_post_{nullptr};
  torch::nn::Linear inlier_proj_{nullptr};
  torch::nn::LayerNorm ln_pre_{nullptr};
  Blocks decoder_;
  torch::nn::LayerNorm ln_post_{nullptr};
  torch::nn::Linear output_proj_{nullptr};
};

}  // namespace diffsac
