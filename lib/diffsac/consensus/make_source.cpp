#include "diffsac/consensus/make_source.h"

#include "diffsac/consensus/napsac_source.h"
#include "diffsac/consensus/prosac_source.h"
#include "diffsac/consensus/weighted_source.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

void CheckLength(const std::string& source, const char* what, std::span<const double> values, Eigen::Index points) {
  if (static_cast<Eigen::Index>(values.size()) == points) return;
  throw Error("source " + source + " needs " + what + " for each of the " + std::to_string(points) + " points, got " +
              std::to_string(values.size()) + " values");
}

}  // namespace

void SourceOptions::Bind(OptionsBinder& b) {
  b.Choice("source", source, {"uniform", "exhaustive", "prosac", "napsac", "p_napsac", "weighted"});
  b.Field("prosac_samples", prosac_samples, AtLeast(1.0));
  b.Field("napsac_neighbors", napsac_neighbors, AtLeast(1));
  b.Field("local_draws", local_draws, AtLeast(0));
}

std::unique_ptr<HypothesisSource> MakeHypothesisSource(const SourceOptions& options, const PointMatrix& points,
                                                       int set_size, std::span<const double> quality,
                                                       std::span<const double> weights) {
  const std::string& name = options.source;
  if (name == "uniform") return std::make_unique<UniformSource>();
  if (name == "exhaustive") return std::make_unique<ExhaustiveSource>();
  if (name == "prosac") {
    CheckLength(name, "a quality", quality, points.rows());
    return std::make_unique<ProsacSource>(quality, set_size, options.prosac_samples);
  }
  if (name == "weighted") {
    CheckLength(name, "a weight", weights, points.rows());
    return std::make_unique<WeightedSource>(weights);
  }
  // A tree over non-finite points makes no sense; the loop gives such points a status, whatever the source.
  const bool usable = points.size() > 0 && points.allFinite();
  if (name == "napsac") {
    if (!usable) return std::make_unique<UniformSource>();
    return std::make_unique<NapsacSource>(points, options.napsac_neighbors);
  }
  if (name == "p_napsac") {
    if (!quality.empty()) CheckLength(name, "a quality", quality, points.rows());
    if (!usable) return std::make_unique<UniformSource>();
    return std::make_unique<ProgressiveNapsacSource>(points, quality, set_size, options.local_draws);
  }
  throw Error("unknown source '" + name + "': expected uniform, exhaustive, prosac, napsac, p_napsac or weighted");
}

}  // namespace diffsac
