#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {

/// Where minimal sets come from. A source fills a flat list of sets: γ indices each, ascending within a set.
/// All sets are drawn before any is scored, from the given generator alone.
class HypothesisSource {
 public:
  virtual ~HypothesisSource() = default;
  /// Appends up to `count` sets of `set_size` distinct points out of `num_points`; returns how many it gave.
  virtual int Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const = 0;
};

/// Uniform random sets; a set may repeat.
class UniformSource : public HypothesisSource {
 public:
  int Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const override;
};

/// Every set once, in lexicographic order (`count` is ignored).
class ExhaustiveSource : public HypothesisSource {
 public:
  int Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const override;
};

/// The number of sets the exhaustive source gives, n over k.
std::int64_t Combinations(int n, int k);

/// How sets are taken from confidences.
///   kMaximum        the γ points of highest confidence; a copy whose set was already taken gives its next best set
///                   that is new (the worst member replaced by the next point in order), so that κ copies give κ sets
///   kProbabilistic  γ points drawn without replacement with probability softmax(confidence / temperature) (Gumbel
///   top-γ)
enum class Selection { kMaximum, kProbabilistic };

/// Sets from κ confidence vectors (the paper's source). Non-finite confidences rank last.
class ConfidenceSource : public HypothesisSource {
 public:
  /// confidences: κ × N row-major, borrowed for the source's lifetime. unique: no set twice.
  ConfidenceSource(std::span<const float> confidences, Selection selection, bool unique, double temperature);
  int Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const override;

 private:
  std::span<const float> confidences_;
  Selection selection_;
  bool unique_;
  double temperature_;
};

/// The number of distinct sets in a flat list of sets with ascending members.
int CountUniqueSets(const std::vector<int>& sets, int set_size);

}  // namespace diffsac
