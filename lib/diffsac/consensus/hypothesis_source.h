#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {

/// Where minimal sets come from. A source fills a flat list of sets: γ indices each, ascending within a set.
/// A source is made for one problem and holds what it knows of it (an order, weights, neighbourhoods), borrowed.
class HypothesisSource {
 public:
  virtual ~HypothesisSource() = default;
  /// Appends the sets of draws first … first + count − 1; returns how many it gave, less than `count` when it has run
  /// out. A set depends on `rng` and on its index alone, so any division into blocks gives the same sets.
  /// Gives none when `num_points` or `set_size` is not what the source was made for.
  virtual int DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                        std::vector<int>* sets) const = 0;
  /// The first `count` sets at once.
  virtual int Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const {
    return DrawBlock(num_points, set_size, 0, count, rng, sets);
  }
};

/// Uniform random sets; a set may repeat. `Draw` takes them from one stream, `DrawBlock` each from its own: the sets
/// differ, their distribution does not.
class UniformSource : public HypothesisSource {
 public:
  int DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                std::vector<int>* sets) const override;
  int Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const override;
};

/// Every set once, in lexicographic order. `Draw` gives them all (`count` is ignored).
class ExhaustiveSource : public HypothesisSource {
 public:
  int DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                std::vector<int>* sets) const override;
  int Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const override;
};

/// Sets that the caller has already, in their order. A set with an index out of range is passed on; the loop counts it
/// as degenerate.
class GivenSource : public HypothesisSource {
 public:
  /// sets: γ indices each, borrowed; a trailing part of a set is left out.
  explicit GivenSource(std::span<const int> sets) : sets_(sets) {}
  int DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                std::vector<int>* sets) const override;

 private:
  std::span<const int> sets_;
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
  /// Where sets must be unique, a block draws all earlier ones again to know them.
  int DrawBlock(int num_points, int set_size, std::int64_t first, int count, const Rng& rng,
                std::vector<int>* sets) const override;
  int Draw(int num_points, int set_size, int count, Rng rng, std::vector<int>* sets) const override;

 private:
  std::span<const float> confidences_;
  Selection selection_;
  bool unique_;
  double temperature_;
};

/// `size` distinct integers below n in random order; rejection where that is faster than a shuffle.
void DrawDistinct(int n, int size, Rng& rng, int* out);

/// The generator of draw `index`: every source derives its sets from these.
inline Rng DrawRng(const Rng& rng, std::int64_t index) { return rng.Fork("draw", static_cast<std::uint64_t>(index)); }

/// The number of distinct sets in a flat list of sets with ascending members.
int CountUniqueSets(const std::vector<int>& sets, int set_size);

}  // namespace diffsac
