#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {

/// Where minimal sets come from: the one thing in which the rows of a table differ. A sampler is made for one problem
/// (its points, γ, a generator) and yields one set after the other, as long as the loop asks for them.
///
/// A sampler depends on what it was made from alone, so the same sets come out for any number of threads. One that was
/// made for fewer than γ points yields none.
class MinimalSampler {
 public:
  virtual ~MinimalSampler() = default;
  /// Fills `set` with the next minimal set, γ indices in ascending order. False, leaving `set` as it may be, when there
  /// is none, or `set` has not the size that the sampler was made for.
  virtual bool Next(std::span<int> set) = 0;
  /// How many points of a set are drawn at random, the others being chosen to suit these: StoppingRule's set.
  virtual int DrawnPoints(int set_size) const { return set_size; }
};

/// Up to `count` sets, one behind the other.
std::vector<int> DrawSets(MinimalSampler& sampler, int set_size, std::int64_t count);

/// Uniform random sets; a set may repeat.
class UniformSampler : public MinimalSampler {
 public:
  UniformSampler(int num_points, int set_size, const Rng& rng)
      : num_points_(num_points), set_size_(set_size), rng_(rng) {}
  bool Next(std::span<int> set) override;

 private:
  int num_points_;
  int set_size_;
  Rng rng_;
};

/// Every set once, in lexicographic order.
class ExhaustiveSampler : public MinimalSampler {
 public:
  ExhaustiveSampler(int num_points, int set_size) : num_points_(num_points), set_size_(set_size) {}
  bool Next(std::span<int> set) override;

 private:
  int num_points_;
  int set_size_;
  std::vector<int> last_;  ///< Empty before the first set.
};

/// Sets that the caller has already, in their order. A set with an index out of range is passed on; the loop counts it
/// as degenerate.
class PrecomputedSampler : public MinimalSampler {
 public:
  /// sets: γ indices each, borrowed; a trailing part of a set is left out.
  explicit PrecomputedSampler(std::span<const int> sets) : rest_(sets) {}
  bool Next(std::span<int> set) override;

 private:
  std::span<const int> rest_;
};

/// One sampler after the other: so many sets of the first (fewer when it runs out), then of the next.
class SequenceSampler : public MinimalSampler {
 public:
  static constexpr std::int64_t kAll = -1;  ///< As many as the sampler has.

  /// count: sets, or kAll.
  void Add(std::unique_ptr<MinimalSampler> sampler, std::int64_t count = kAll);
  bool Next(std::span<int> set) override;

 private:
  struct Part {
    std::unique_ptr<MinimalSampler> sampler;
    std::int64_t count;  ///< kAll: as many as it has.
    std::int64_t drawn = 0;
  };
  std::vector<Part> parts_;
  std::size_t current_ = 0;
};

/// The number of sets the exhaustive sampler gives, n over k; the largest number there is where it is more.
std::int64_t Combinations(int n, int k);

/// Every set, where there are no more than `count`; else so many uniform ones. One behind the other.
std::vector<int> DrawAllOrSome(int num_points, int set_size, std::int64_t count, const Rng& rng);

/// `size` distinct integers below n in random order; rejection where that is faster than a shuffle.
void DrawDistinct(int n, int size, Rng& rng, int* out);

/// The generator of draw `index`, of samplers whose draws each have one of their own.
inline Rng DrawRng(const Rng& rng, std::int64_t index) { return rng.Fork("draw", static_cast<std::uint64_t>(index)); }

/// The number of distinct sets in a flat list of sets with ascending members.
int CountUniqueSets(const std::vector<int>& sets, int set_size);

/// Sets that results report: as many as the paper's κ.
inline constexpr int kReportedSets = 20;
/// The first kReportedSets of a flat list of sets, each on its own.
std::vector<std::vector<int>> FirstSets(const std::vector<int>& sets, int set_size);

}  // namespace diffsac
