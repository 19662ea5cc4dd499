#include "diffsac/consensus/make_source.h"

#include "diffsac/consensus/napsac_source.h"
#include "diffsac/consensus/prosac_source.h"
#include "diffsac/core/status.h"

namespace diffsac {
namespace {

void CheckLength(const char* source, std::span<const double> quality, Eigen::Index points) {
  if (static_cast<Eigen::Index>(quality.size()) == points) return;
  throw Error(std::string("source ") + source + " needs a quality for each of the " + std::to_string(points) +
              " points, got " + std::to_string(quality.size()) + " values");
}

}  // namespace

void SourceOptions::Bind(OptionsBinder& b) {
  b.Field("source", source).Help("where minimal sets come from; prosac needs a quality, p_napsac uses one");
  b.Field("prosac_samples", prosac_samples, AtLeast(1.0))
      .OnlyIf(source == SourceKind::kProsac, "source: prosac")
      .Help("after so many draws it is uniform");
  b.Field("napsac_neighbors", napsac_neighbors, Within(1, 1e5))
      .OnlyIf(source == SourceKind::kNapsac, "source: napsac")
      .Help("how many nearest points count as neighbours");
  b.Field("local_draws", local_draws, AtLeast(0))
      .OnlyIf(source == SourceKind::kProgressiveNapsac, "source: p_napsac")
      .Help("draws a point before sampling is global");
}

std::unique_ptr<HypothesisSource> MakeHypothesisSource(const SourceOptions& options, const PointMatrix& points,
                                                       int set_size, const Rng& rng, std::span<const double> quality) {
  const int size = static_cast<int>(points.rows());
  // A tree over non-finite points makes no sense; the loop gives such points a status, whatever the source.
  const bool usable = points.size() > 0 && points.allFinite();
  switch (options.source) {
    case SourceKind::kExhaustive:
      return std::make_unique<ExhaustiveSource>(size, set_size);
    case SourceKind::kProsac:
      CheckLength("prosac", quality, points.rows());
      return std::make_unique<ProsacSource>(quality, set_size, rng, options.prosac_samples);
    case SourceKind::kNapsac:
      if (usable) return std::make_unique<NapsacSource>(points, set_size, options.napsac_neighbors, rng);
      break;
    case SourceKind::kProgressiveNapsac:
      if (!quality.empty()) CheckLength("p_napsac", quality, points.rows());
      if (usable) return std::make_unique<ProgressiveNapsacSource>(points, quality, set_size, rng, options.local_draws);
      break;
    case SourceKind::kUniform:
      break;
  }
  return std::make_unique<UniformSource>(size, set_size, rng);
}

}  // namespace diffsac
