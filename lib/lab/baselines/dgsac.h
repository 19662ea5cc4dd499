#pragma once

#include <cstdint>
#include <vector>

#include "diffsac/ransac/sample_consensus.h"
#include "lab/options/options.h"

namespace diffsac {

/// When sampling ends: kExplained, the paper's, once fewer than γ points are explained better by another round |
/// kBudget.
enum class DgsacStopping { kExplained, kBudget };
template <>
inline constexpr auto kEnumNames<DgsacStopping> = NamesOf<DgsacStopping>({{DgsacStopping::kExplained, "explained"},
                                                                          {DgsacStopping::kBudget, "budget"}});

/// Density guided sampling and consensus (Tiwari and Anand, WACV 2018): docs/dgsac.md has the steps and what the paper
/// leaves open. Nothing here is a length: no inlier threshold, no noise scale.
struct DgsacOptions {
  int max_iterations = 1000;
  DgsacStopping stopping = DgsacStopping::kExplained;
  int refit_rounds = 10;
  void Bind(OptionsBinder& b);
};

/// Most points. Their order by each hypothesis is kept, 12 bytes a point: 4 GB for so many and 1000 hypotheses.
inline constexpr int kMostDgsacPoints = 300000;

struct DgsacResult {
  Status status = Status::kNoModel;
  ModelParameters model;
  std::vector<std::uint8_t> inliers;  ///< By the density alone.
  double sigma = 0.0;                 ///< Root mean square residual of these inliers, γ of them not counted.
  double extent = 0.0;                ///< Largest residual of these inliers.
  double evidence = 0.0;              ///< Of the model (InlierExtent).
  int instances = 0;                  ///< Found; 0 when the model was taken although its contrast was low.
  int hypotheses = 0;                 ///< Models solved or fitted.
  int unique_minimal_sets = 0;
  std::vector<std::vector<int>> first_sets;  ///< Up to kReportedSets, as they were drawn.
  std::vector<int> sets;                     ///< All minimal sets, γ indices each.
  int guided_from = 0;                       ///< The first set that was drawn after a look at densities.
  StopReason stop = StopReason::kNotRun;     ///< kBudget, or kConfidence once all points are explained.
};

/// Never throws for bad data: a status says what was wrong; kNoModel when every set was degenerate or no hypothesis is
/// denser at 0 than elsewhere, kTooManyPoints beyond kMostDgsacPoints. Depends on points, options and rng alone.
template <MinimalModel Model>
DgsacResult EstimateDgsac(const PointMatrix& points, const DgsacOptions& options, const Rng& rng);

}  // namespace diffsac
