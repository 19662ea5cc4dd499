#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include <memory>
#include <string>

#include "diffsac/core/options.h"
#include "diffsac/core/random.h"
#include "diffsac/denoiser/point_batch.h"

namespace diffsac {

/// What a network computes once a problem, shared by all κ copies and all reverse steps.
struct Context {
  torch::Tensor points;          ///< [B, N, W] conditioning features.
  torch::Tensor mask;            ///< [B, N] bool, undefined when all points are real.
  torch::Tensor inlier_logits;   ///< [B, N] logit of "is an inlier"; undefined without the inlier head.
  torch::Tensor agreements;      ///< [B, N, M] unit preference vectors, for `relation`; else undefined.
};

/// What a network's layers are.
///   kPointTransformer  "point_transformer": the paper's
///   kPooled            "pooled": point-wise layers with pooled context, for CPUs
/// and the others of the paper's ablation (e):
///   kMlp               "mlp": each point by itself
///   kDgcnn             "dgcnn": edge convolutions over nearest points in feature space
enum class DenoiserKind { kPointTransformer, kPooled, kMlp, kDgcnn };
template <>
inline constexpr auto kEnumNames<DenoiserKind> =
    NamesOf<DenoiserKind>({{DenoiserKind::kPointTransformer, "point_transformer"},
                           {DenoiserKind::kPooled, "pooled"},
                           {DenoiserKind::kMlp, "mlp"},
                           {DenoiserKind::kDgcnn, "dgcnn"}});

struct DenoiserOptions {
  DenoiserKind kind = DenoiserKind::kPooled;
  int width = 64;
  int heads = 4;            ///< attention heads, point_transformer
  int encoder_layers = 4;   ///< blocks before c_t enters: computed once a problem. 0 is the paper's joint network.
  int layers = 2;           ///< blocks after c_t has entered: computed for each copy and step
  int neighbors = 16;       ///< of a point, dgcnn
  bool inlier_head = true;  ///< a second output: each point's inlier probability, for the learned refit
  /// Each point also sees how much it agrees with the points that are confident now (PointRelation): what a set of
  /// points of one structure among several needs. For features with preferences.
  bool relation = false;
  bool self_conditioning = false;   ///< the previous ĉ_0 is a second input (Chen et al., "Analog bits", 2023)
  void Bind(OptionsBinder& b);
};

/// 𝔇_θ(c_t, t, χ) = ĉ_0, split so that what does not depend on c_t is computed once.
///
/// Outputs are equivariant to the order of the points, and a problem's output does not depend on its batch mates.
class Denoiser : public torch::nn::Module {
 public:
  /// Conditioning features of a batch.
  virtual Context Encode(const PointBatch& batch) = 0;
  /// c_t: [B, κ, N]; t: [B, κ] or one value, diffusion times as floats; previous: ĉ_0 of the step before [B, κ, N], used
  /// with self_conditioning (undefined: zeros). Returns the raw output [B, κ, N]: ĉ_0 or its logit, as the loss says.
  virtual torch::Tensor Denoise(const Context& context, const torch::Tensor& c_t, const torch::Tensor& t,
                                const torch::Tensor& previous = {}) = 0;
};

/// Where the columns of features stand that a network knows by their meaning.
struct FeatureColumns {
  int width = 0;             ///< All of them.
  int first_preference = -1; ///< Of the preference features, which are the last; -1 without any (PointFeatures).
  FeatureColumns(int all, int preference = -1) : width(all), first_preference(preference) {}
};

/// Builds a network for such features; its weights depend on `rng` alone. Throws Error for bad options, and for
/// `relation` without preferences.
std::shared_ptr<Denoiser> MakeDenoiser(const DenoiserOptions& options, const FeatureColumns& columns, Rng rng);

/// Trainable values in a network.
std::int64_t CountParameters(const torch::nn::Module& module);

}  // namespace diffsac
