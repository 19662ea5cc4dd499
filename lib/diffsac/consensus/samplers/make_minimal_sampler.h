#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "diffsac/consensus/samplers/minimal_sampler.h"
#include "diffsac/core/enum_names.h"
#include "diffsac/geometry/points.h"

namespace diffsac {

/// The samplers that need no network. prosac needs matching ratios, p_napsac uses them where they are known; weighted
/// draws by the points' weights (PointWeights in problem/problem.h), uniformly where there are none; edges and
/// edge_ratios draw matches of two clouds whose lengths agree, or do so by one scale (EdgeSampler).
enum class MinimalSamplerKind {
  kUniform,
  kExhaustive,
  kProsac,
  kNapsac,
  kProgressiveNapsac,
  kWeighted,
  kEdges,
  kEdgeRatios
};
template <>
inline constexpr auto kEnumNames<MinimalSamplerKind> =
    NamesOf<MinimalSamplerKind>({{MinimalSamplerKind::kUniform, "uniform"},
                                 {MinimalSamplerKind::kExhaustive, "exhaustive"},
                                 {MinimalSamplerKind::kProsac, "prosac"},
                                 {MinimalSamplerKind::kNapsac, "napsac"},
                                 {MinimalSamplerKind::kProgressiveNapsac, "p_napsac"},
                                 {MinimalSamplerKind::kWeighted, "weighted"},
                                 {MinimalSamplerKind::kEdges, "edges"},
                                 {MinimalSamplerKind::kEdgeRatios, "edge_ratios"}});

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
