#include "diffsac/ransac/samplers/make_minimal_sampler.h"

#include "diffsac/core/status.h"
#include "diffsac/ransac/samplers/length_consistency_sampler.h"
#include "diffsac/ransac/samplers/napsac_sampler.h"
#include "diffsac/ransac/samplers/prosac_sampler.h"
#include "diffsac/ransac/samplers/weighted_sampler.h"

namespace diffsac {
namespace {

/// By how many thresholds lengths may differ: by 1.8 σ where an inlier is within 2.5.
constexpr double kLengthTolerance = 1.0;

void CheckLength(const std::string& sampler, const char* what, std::span<const double> values, Eigen::Index points) {
  if (static_cast<Eigen::Index>(values.size()) == points) return;
  throw Error("sampler " + sampler + " needs a " + what + " for each of the " + std::to_string(points) +
              " points, got " + std::to_string(values.size()) + " values");
}

}  // namespace

std::unique_ptr<MinimalSampler> MakeMinimalSampler(const MinimalSamplerOptions& options, const PointMatrix& points,
                                                   int set_size, const Rng& rng, std::span<const double> quality,
                                                   std::span<const double> weights, double threshold) {
  const int size = static_cast<int>(points.rows());
  // A tree over non-finite points makes no sense; the loop gives such points a status, whatever the sampler.
  const bool usable = points.size() > 0 && points.allFinite();
  switch (options.sampler) {
    case MinimalSamplerKind::kExhaustive:
      return std::make_unique<ExhaustiveSampler>(size, set_size);
    case MinimalSamplerKind::kProsac:
      CheckLength("prosac", "matching ratio", quality, points.rows());
      return std::make_unique<ProsacSampler>(quality, set_size, rng);
    case MinimalSamplerKind::kNapsac:
      if (usable) return std::make_unique<NapsacSampler>(points, set_size, options.napsac_neighbors, rng);
      break;
    case MinimalSamplerKind::kProgressiveNapsac:
      if (!quality.empty()) CheckLength("p_napsac", "matching ratio", quality, points.rows());
      if (usable) return std::make_unique<ProgressiveNapsacSampler>(points, quality, set_size, rng);
      break;
    case MinimalSamplerKind::kWeighted:
      if (weights.empty()) break;
      CheckLength("weighted", "weight", weights, points.rows());
      return std::make_unique<WeightedSampler>(weights, set_size, rng);
    case MinimalSamplerKind::kLengthConsistency:
    case MinimalSamplerKind::kLengthRatioConsistency:
      if (!usable || points.cols() != 6 || set_size != 3) break;
      return std::make_unique<LengthConsistencySampler>(points, kLengthTolerance * threshold,
                                                        options.sampler == MinimalSamplerKind::kLengthRatioConsistency,
                                                        quality, rng);
    case MinimalSamplerKind::kUniform:
      break;
  }
  return std::make_unique<UniformSampler>(size, set_size, rng);
}

}  // namespace diffsac
