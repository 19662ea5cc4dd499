#pragma once

#include <set>
#include <span>
#include <vector>

#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac {

/// How sets are taken from confidences.
///   kMaximum        the γ points of highest confidence; a copy whose set was already taken gives its next best set
///                   that is new (the worst member replaced by the next point in order), so that κ copies give κ sets
///   kProbabilistic  γ points drawn without replacement with probability softmax(confidence / temperature)
///                   (Gumbel top-γ)
enum class Selection { kMaximum, kProbabilistic };

/// Sets from κ confidence vectors (the paper's sampler), one from each in turn. Non-finite confidences rank last. After
/// κ sets the copies are gone through again, where that can give something new: never for kMaximum with repeats.
class ConfidenceSampler : public MinimalSampler {
 public:
  /// confidences: κ × N row-major, borrowed for the sampler's lifetime. unique: no set twice.
  ConfidenceSampler(std::span<const float> confidences, int num_points, int set_size, Selection selection, bool unique,
                    double temperature, const Rng& rng);
  bool Next(std::span<int> set) override;

 private:
  using Set = std::vector<int>;
  /// The set of the next copy; empty where it has no new one.
  Set FromCopy(std::span<const float> copy, Rng& rng);

  std::span<const float> confidences_;
  int num_points_;
  int set_size_;
  Selection selection_;
  bool unique_;
  double temperature_;
  Rng rng_;
  int copies_;
  std::int64_t draws_ = 0;
  int fruitless_ = 0;  ///< Copies in a row that gave nothing new.
  std::set<Set> taken_;
};

}  // namespace diffsac
