#pragma once

#include "diffsac/core/enum_names.h"
#include "diffsac/core/stored_options.h"
#include "diffsac/guidance/diffusion/noise_schedule.h"
#include "diffsac/guidance/diffusion/prediction.h"
#include "diffsac/problem/point_features.h"

namespace diffsac {

/// What a network's layers are.
///   kPointTransformer  "point_transformer": the paper's
///   kPooled            "pooled": point-wise layers with pooled context, for CPUs
/// and the others of the paper's ablation (e):
///   kMlp               "mlp": each point by itself
///   kDgcnn             "dgcnn": edge convolutions over nearest points in feature space
enum class DenoiserKind { kPointTransformer, kPooled, kMlp, kDgcnn };
template <>
inline constexpr auto kEnumNames<DenoiserKind> = NamesOf<DenoiserKind>({{DenoiserKind::kPointTransformer,
                                                                         "point_transformer"},
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
};

/// Where the columns of features stand that a network knows by their meaning.
struct FeatureColumns {
  int width = 0;            ///< All of them.
  int first_residual = -1;  ///< Of the residual features, which are the last; -1 without any (PointFeatures).
  FeatureColumns(int all, int residual = -1) : width(all), first_residual(residual) {}
};

/// Everything that must be the same in training and in inference.
struct NetworkOptions {
  PointFeaturesOptions features;
  DenoiserOptions denoiser;
  NoiseScheduleOptions schedule;
  /// No diffusion: the network is trained without noise (c_t = 0, t = T − 1) to predict c_0 from the points at once,
  /// and is called once; samplers are not used. The paper's ablation (a), "direct learning confidence".
  bool direct = false;
  DiffusionLossKind loss = DiffusionLossKind::kBce;  ///< What the network puts out.
};

/// The group `network` of a checkpoint's configuration. Throws Error naming file and key for what no network has.
NetworkOptions ReadNetworkOptions(const StoredOptions& network);

}  // namespace diffsac
