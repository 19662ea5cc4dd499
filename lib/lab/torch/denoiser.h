#pragma once

#include <torch/nn/module.h>
#include <torch/nn/modules/linear.h>
#include <torch/nn/modules/normalization.h>
#include <torch/types.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/guidance/engine/network_options.h"
#include "lab/torch/point_batch.h"
#include "lab/torch/point_block.h"
#include "lab/torch/point_relation.h"

namespace diffsac {

/// What a network computes once a problem, shared by all κ copies and all reverse steps.
struct Context {
  torch::Tensor points;         ///< [B, N, W] conditioning features.
  torch::Tensor mask;           ///< [B, N] bool, undefined when all points are real.
  torch::Tensor inlier_logits;  ///< [B, N] logit of "is an inlier"; undefined without the inlier head.
  torch::Tensor agreements;     ///< [B, N, M] unit preference vectors, for `relation`; else undefined.
};

/// 𝔇_θ(c_t, t, χ) = ĉ_0, split so that what does not depend on c_t is computed once:
///
///   context = norm(encoder(norm(FC(χ)))),   output = FC(norm(decoder(norm(FC(c) + MLP(t) + context)))).
///
/// With `relation` c has behind it what PointRelation says of each point. What is left out (a norm, the encoder, the
/// inlier head) is passed by. The options' `kind` says of which blocks (lab/torch/point_block.h) encoder and decoder
/// are; `point_transformer` with encoder_layers = 0 is the paper's joint network. Modules have the names that
/// checkpoints have. The output projection starts at zero.
///
/// Outputs are equivariant to the order of the points, and a problem's output does not depend on its batch mates.
class Denoiser : public torch::nn::Module {
 public:
  /// For such features; its weights depend on `rng` alone. Throws Error for bad options, and for `relation` without
  /// preferences.
  Denoiser(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng);
  /// Conditioning features of a batch.
  Context Encode(const PointBatch& batch);
  /// c_t: [B, κ, N]; t: [B, κ] or one value, diffusion times as floats. Returns the raw output [B, κ, N]: ĉ_0 or
  /// its logit, as the loss says.
  torch::Tensor Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t);

 private:
  using Blocks = std::vector<std::shared_ptr<PointBlock>>;

  void AddTransformer(const Rng& rng);
  void AddPointwise(const Rng& rng);
  /// Registers what FC(c) reads and FC(c) itself: c_t, with the option the relations.
  void AddConfidenceInput(const Rng& rng);
  void AddInlierHead(const Rng& rng);
  /// Registers a linear layer that starts from rng.Fork(name), kDefault unless `zero`.
  torch::nn::Linear AddLinear(const char* name, std::int64_t in, std::int64_t out, const Rng& rng, bool zero = false);
  torch::nn::LayerNorm AddNorm(const char* name);
  /// Registers name0, name1, … of rng.Fork(name, i).
  Blocks AddBlocks(const std::string& name, int count, const Rng& rng);
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

/// Sinusoidal embedding of diffusion times: [cos(t·f), sin(t·f)] with f_i = 10000^(−i/(width/2)), the cosine half
/// first (Point-E, Nichol et al., 2022). t: any shape, float. Returns [..., width]; width must be even.
torch::Tensor TimestepEmbedding(const torch::Tensor& t, std::int64_t width);

/// Trainable values in a network.
std::int64_t CountParameters(const torch::nn::Module& module);

}  // namespace diffsac
