#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "diffsac/ransac/samplers/neighbor_index.h"
#include "diffsac/ransac/samplers/prosac_sampler.h"

namespace diffsac {

/// Neighbours sampled together (Myatt et al., "NAPSAC: high noise, high dimensional robust estimation", BMVC 2002): a
/// uniform first point, and γ − 1 of its k nearest points. Nearest points rather than a ball of some radius, so that no
/// scale has to be known and no draw fails.
class NapsacSampler : public MinimalSampler {
 public:
  /// neighbors: k; at least γ − 1 are taken.
  NapsacSampler(const PointMatrix& points, int set_size, int neighbors, const Rng& rng)
      : index_(points), set_size_(set_size), neighbors_(neighbors), rng_(rng) {}
  bool Next(std::span<int> set) override;

 private:
  NeighborIndex index_;
  int set_size_;
  int neighbors_;
  Rng rng_;
  std::int64_t draws_ = 0;
};

/// Progressive NAPSAC (Barath, Noskova, Ivashechkin, Matas, "MAGSAC++, a fast, reliable and accurate robust estimator",
/// CVPR 2020, section 4): the neighbourhood of each point grows with the number of sets that started from it, by
/// PROSAC's growth function for the γ − 1 other points, so that local sampling blends into global.
///
/// The first point is drawn from the best g(t) points where a quality is given (PROSAC's growing set), else from all.
/// At its t-th use, the set holds its k-th nearest point, k = g_local(t), and γ − 2 nearer ones. After `local_draws`·N
/// draws the sampler is a PROSAC or a uniform one.
class ProgressiveNapsacSampler : public MinimalSampler {
 public:
  static constexpr int kLocalDraws = 20;

  /// quality: lower = better; empty: no order is known.
  ProgressiveNapsacSampler(const PointMatrix& points, std::span<const double> quality, int set_size, const Rng& rng,
                           int local_draws = kLocalDraws);
  bool Next(std::span<int> set) override;

 private:
  int FirstPoint(Rng& draw);
  void DrawAround(int center, std::int64_t hits, Rng& draw, int* set);

  NeighborIndex index_;
  int set_size_;
  Rng rng_;
  std::int64_t local_draws_;
  std::int64_t draws_ = 0;
  std::vector<std::int64_t> hits_;      ///< How often each point came first.
  std::vector<int> order_;              ///< By quality; empty when none is known.
  std::vector<GrowthFunction> global_;  ///< For the first point; one, none without quality.
  std::vector<GrowthFunction> local_;   ///< For the others; one, none when γ = 1 or there are too few points.
  std::unique_ptr<MinimalSampler> global_sampler_;  ///< After the local draws.
};

}  // namespace diffsac
