#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>

#include "diffsac/consensus/hypothesis_source.h"
#include "diffsac/core/options.h"
#include "diffsac/geometry/points.h"

namespace diffsac {

/// The source of minimal sets, by name.
struct SourceOptions {
  /// "uniform" | "exhaustive" | "prosac" | "napsac" | "p_napsac" | "weighted". prosac needs a quality; p_napsac uses
  /// one where it is known; weighted needs weights. Every set of the exhaustive source is tried only if
  /// ConsensusOptions::max_iterations allows as many.
  std::string source = "uniform";
  double prosac_samples = 200000.0;  ///< prosac: after so many draws it is uniform.
  int napsac_neighbors = 20;         ///< napsac: how many nearest points count as neighbours.
  int local_draws = 20;              ///< p_napsac: draws a point before sampling is global.
  void Bind(OptionsBinder& b);
};

/// The source for one problem. Borrows nothing but what it is given for weights and quality during the call.
/// Throws Error when quality or weights are needed and absent, or are not one number a point.
std::unique_ptr<HypothesisSource> MakeHypothesisSource(const SourceOptions& options, const PointMatrix& points,
                                                       int set_size, std::span<const double> quality = {},
                                                       std::span<const double> weights = {});

}  // namespace diffsac
