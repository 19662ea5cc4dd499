#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac {

/// PROSAC's growth function (Chum and Matas, "Matching with PROSAC", CVPR 2005, section 2.2). Of T_N uniform sets of m
/// out of N points, T_n = T_N·Π (n−i)/(N−i) lie on average within the best n; T'_m = 1,
/// T'_(n+1) = T'_n + ⌈T_(n+1) − T_n⌉ are whole numbers for them, and draw t takes its set from the best
/// g(t) = min {n : T'_n ≥ t}.
/// T_N is at most N over m, the number of sets there are: with more, few points of a small m would repeat their sets.
/// T'_n is worked out as far as it is asked for.
class GrowthFunction {
 public:
  /// 0 < set_size ≤ num_points.
  GrowthFunction(int set_size, int num_points, double samples);
  /// g(t) for the t-th draw, t ≥ 1; num_points + 1 once T'_N draws are over and sets come from all points.
  int SubsetSize(std::int64_t t);

 private:
  double Average(int n) const;

  int set_size_;
  int num_points_;
  double total_;                      ///< T_N.
  double last_;                       ///< T_n of the last n below.
  std::vector<std::int64_t> limits_;  ///< T'_n for n = m …
};

/// Indices by rising quality number; the lower index first where they tie, non-finite numbers last.
std::vector<int> OrderByQuality(std::span<const double> quality);

/// The same order, sorted as far as it is asked for: few draws look at few points.
class QualityOrder {
 public:
  explicit QualityOrder(std::span<const double> quality);
  int size() const { return static_cast<int>(points_.size()); }
  /// The point at a place below size().
  int operator[](int place);

 private:
  std::vector<std::pair<double, int>> points_;  ///< Quality and index.
  int sorted_ = 0;                              ///< As many at the front are in their places.
};

/// Progressive sampling: draw t holds the g(t)-th best point and m − 1 of the better ones, and later all points are
/// drawn uniformly.
class ProsacSampler : public MinimalSampler {
 public:
  /// T_N of the paper: after so many draws the sampler is a uniform one.
  static constexpr double kSamples = 200000.0;

  /// quality: one number a point, lower = better (a matching ratio). set_size: γ. first_draw: how many draws are past
  /// already, for a sampler that comes after another.
  ProsacSampler(std::span<const double> quality, int set_size, const Rng& rng, double samples = kSamples,
                std::int64_t first_draw = 0);
  bool Next(std::span<int> set) override;

 private:
  int set_size_;
  Rng rng_;
  std::int64_t draws_;
  QualityOrder order_;
  std::vector<GrowthFunction> growth_;  ///< One, none when there are too few points.
};

}  // namespace diffsac
