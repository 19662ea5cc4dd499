#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include <memory>
#include <string>

#include "diffsac/core/random.h"
#include "diffsac/guidance/engine/network_options.h"
#include "lab/torch/point_batch.h"

namespace diffsac {

/// What a network computes once a problem, shared by all κ copies and all reverse steps.
struct Context {
  torch::Tensor points;         ///< [B, N, W] conditioning features.
  torch::Tensor mask;           ///< [B, N] bool, undefined when all points are real.
  torch::Tensor inlier_logits;  ///< [B, N] logit of "is an inlier"; undefined without the inlier head.
  torch::Tensor agreements;     ///< [B, N, M] unit preference vectors, for `relation`; else undefined.
};

/// 𝔇_θ(c_t, t, χ) = ĉ_0, split so that what does not depend on c_t is computed once.
///
/// Outputs are equivariant to the order of the points, and a problem's output does not depend on its batch mates.
class Denoiser : public torch::nn::Module {
 public:
  /// Conditioning features of a batch.
  virtual Context Encode(const PointBatch& batch) = 0;
  /// c_t: [B, κ, N]; t: [B, κ] or one value, diffusion times as floats. Returns the raw output [B, κ, N]: ĉ_0 or
  /// its logit, as the loss says.
  virtual torch::Tensor Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t) = 0;
};

/// Builds a network for such features; its weights depend on `rng` alone. Throws Error for bad options, and for
/// `relation` without preferences.
std::shared_ptr<Denoiser> MakeDenoiser(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng);

/// Trainable values in a network.
std::int64_t CountParameters(const torch::nn::Module& module);

}  // namespace diffsac
