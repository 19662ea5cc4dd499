#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "diffsac/consensus/hypothesis_source.h"
#include "diffsac/core/options.h"
#include "diffsac/geometry/points.h"

namespace diffsac {

/// The sources that need no network. prosac needs a quality, p_napsac uses one where it is known.
enum class SourceKind { kUniform, kExhaustive, kProsac, kNapsac, kProgressiveNapsac };
template <>
inline constexpr auto kEnumNames<SourceKind> = NamesOf<SourceKind>({{SourceKind::kUniform, "uniform"},
                                                                    {SourceKind::kExhaustive, "exhaustive"},
                                                                    {SourceKind::kProsac, "prosac"},
                                                                    {SourceKind::kNapsac, "napsac"},
                                                                    {SourceKind::kProgressiveNapsac, "p_napsac"}});

/// The source of minimal sets, by name.
struct SourceOptions {
  SourceKind source = SourceKind::kUniform;
  double prosac_samples = 200000.0;  ///< prosac: after so many draws it is uniform.
  int napsac_neighbors = 20;         ///< napsac: how many nearest points count as neighbours.
  int local_draws = 20;              ///< p_napsac: draws a point before sampling is global.
  void Bind(OptionsBinder& b);
};

/// The source for one problem; borrows nothing. quality: one number a point, lower is better; empty: unknown. Throws
/// Error when a quality is needed and absent, or is not one number a point.
std::unique_ptr<HypothesisSource> MakeHypothesisSource(const SourceOptions& options, const PointMatrix& points,
                                                       int set_size, const Rng& rng,
                                                       std::span<const double> quality = {});

}  // namespace diffsac
