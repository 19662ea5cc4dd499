#pragma once

#include <span>
#include <vector>

#include "diffsac/consensus/neighbor_index.h"
#include "diffsac/consensus/prosac_source.h"

namespace diffsac {

/// Neighbours sampled together (Myatt et al., "NAPSAC: high noise, high dimensional robust estimation", BMVC 2002): a
/// uniform first point, and γ − 1 of its k nearest points. Nearest points rather than a ball of some radius, so that no
/// scale has to be known and no draw fails.
class NapsacSource : public HypothesisSource {
 public:
  /// neighbors: k; at least γ − 1 are taken.
  NapsacSource(const PointMatrix& points, int neighbors) : index_(points), neighbors_(neighbors) {}
  int DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                std::vector<int>* sets) const override;

 private:
  NeighborIndex index_;
  int neighbors_;
};

/// Progressive NAPSAC (Barath, Noskova, Ivashechkin, Matas, "MAGSAC++, a fast, reliable and accurate robust estimator",
/// CVPR 2020, section 4): the neighbourhood of each point grows with the number of sets that started from it, by
/// PROSAC's growth function for the γ − 1 other points, so that local sampling blends into global.
///
/// The first point is drawn from the best g(t) points where a quality is given (PROSAC's growing set), else from all.
/// At its t-th use, the set holds its k-th nearest point, k = g_local(t), and γ − 2 nearer ones. After `local_draws`·N
/// draws the source is a PROSAC or a uniform one.
class ProgressiveNapsacSource : public HypothesisSource {
 public:
  static constexpr int kLocalDraws = 20;

  /// quality: lower = better; empty: no order is known.
  ProgressiveNapsacSource(const PointMatrix& points, std::span<const double> quality, int set_size,
                          int local_draws = kLocalDraws);
  int DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                std::vector<int>* sets) const override;

 private:
  int FirstPoint(std::int64_t index, Rng& draw) const;
  void DrawAround(int center, std::int64_t hits, Rng& draw, int* set) const;

  NeighborIndex index_;
  int set_size_;
  std::int64_t local_draws_;
  std::vector<int> order_;              ///< By quality; empty when none is known.
  std::vector<GrowthFunction> global_;  ///< For the first point; one, none without quality.
  std::vector<GrowthFunction> local_;   ///< For the others; one, none when γ = 1 or there are too few points.
  ProsacSource prosac_;
};

}  // namespace diffsac
