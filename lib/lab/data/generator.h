#pragma once

#include <cstdint>
#include <string>

#include "diffsac/core/random.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// What every generator is told beside what it draws.
struct GeneratorOptions {
  std::int64_t size = -1;
  std::string split = "train";
  void BindStream(OptionsBinder& b, const char* help = "its name; splits of different names never share a stream");
};

/// Data that is drawn: an example depends on the options, the seed, the split and its index alone.
class GeneratedDataset : public Dataset {
 public:
  std::int64_t size() const override { return size_; }
  /// Throws std::out_of_range behind the last one.
  Example Get(std::uint64_t index) const override;

 protected:
  /// `stream`: of the random numbers; `ids`: what examples' ids begin with.
  GeneratedDataset(const GeneratorOptions& options, const std::string& stream, std::string ids, std::uint64_t seed)
      : size_(options.size), ids_(std::move(ids)), root_(Rng(seed).Fork(stream)) {}

 private:
  /// All but index and scene; the example's id is what stands behind its number in it.
  virtual Example Draw(std::uint64_t index, const Rng& rng) const = 0;

  std::int64_t size_;
  std::string ids_;
  Rng root_;
};

/// A whole number of a range, uniformly.
int DrawWhole(const Range& range, Rng& rng);
/// Whether both ends of a range are whole numbers.
bool IsWhole(const Range& range);

/// Points and inliers of one problem: round(N (1 − ratio)) inliers, at least γ + 1 and at most N.
struct PointCounts {
  int total = 0;
  int inliers = 0;
};
PointCounts DrawCounts(const Range& num_points, const Range& outlier_ratio, Task task, Rng rng);
/// Throws Error unless every problem can hold γ + 1 points.
void CheckCounts(const Range& num_points, Task task);

}  // namespace diffsac
