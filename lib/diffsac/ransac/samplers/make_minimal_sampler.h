#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "diffsac/core/enum_names.h"
#include "diffsac/geometry/points.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac {

/// The samplers that need no network. prosac needs matching ratios, p_napsac uses them where they are known; weighted
/// draws by the points' weights (PointWeights in problem/problem.h), uniformly where there are none; length_consistency
/// and length_ratio_consistency draw matches of two clouds whose lengths agree, or do so by one scale
/// (LengthConsistencySampler).
enum class MinimalSamplerKind {
  kUniform,
  kExhaustive,
  kProsac,
  kNapsac,
  kProgressiveNapsac,
  kWeighted,
  kLengthConsistency,
  kLengthRatioConsistency
};
template <>
inline constexpr auto kEnumNames<MinimalSamplerKind> =
    NamesOf<MinimalSamplerKind>({{MinimalSamplerKind::kUniform, "uniform"},
                                 {MinimalSamplerKind::kExhaustive, "exhaustive"},
                                 {MinimalSamplerKind::kProsac, "prosac"},
                                 {MinimalSamplerKind::kNapsac, "napsac"},
                                 {MinimalSamplerKind::kProgressiveNapsac, "p_napsac"},
                                 {MinimalSamplerKind::kWeighted, "weighted"},
                                 {MinimalSamplerKind::kLengthConsistency, "length_consistency"},
                                 {MinimalSamplerKind::kLengthRatioConsistency, "length_ratio_consistency"}});

/// The sampler of minimal sets, by name.
struct MinimalSamplerOptions {
  MinimalSamplerKind sampler = MinimalSamplerKind::kUniform;
  int napsac_neighbors = 20;  ///< napsac: how many nearest points count as neighbours.
};

/// The sampler for one problem; borrows nothing. quality: one number a point, lower is better (a matching ratio);
/// empty: unknown. weights: one number a point, in proportion to which `weighted` draws. Throws Error when one of them
/// is needed and absent, or is not one number a point. threshold: what an inlier is, for edges.
std::unique_ptr<MinimalSampler> MakeMinimalSampler(const MinimalSamplerOptions& options, const PointMatrix& points,
                                                   int set_size, const Rng& rng, std::span<const double> quality = {},
                                                   std::span<const double> weights = {}, double threshold = 0.0);

}  // namespace diffsac
