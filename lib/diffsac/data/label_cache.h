#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/data/labels.h"
#include "diffsac/data/problem.h"

namespace diffsac {

/// What decides the examples of a dataset: its resolved options and the seed, as text.
std::string DatasetKey(const Config& data, std::uint64_t seed);

/// The optimal minimal sets of a finite dataset in an HDF5 file, so that they are searched for once and not in every
/// epoch. The file holds, for E examples, the M = top_m best sets of γ points:
///   key           text: version, DatasetKey and the label options it was made with
///   sets          E × M × γ, 32-bit integers, −1 where there are fewer sets
///   distances     E × M
///   fingerprints  E: a hash of each example's id, points and true inliers
/// A file with another key is made anew; a fingerprint that does not fit is an Error, so that data that changed under
/// the same options is found out. Rows are read when they are asked for.
///
/// Example:
/// ```
/// LabelCache cache(*dataset, DatasetKey(data, seed), labels, folder + "/label_cache.h5", threads);
/// const std::vector<RankedSet> sets = cache.Sets(dataset->Get(i));   // as OptimalMinimalSets(…, labels.top_m)
/// ```
class LabelCache {
 public:
  /// Opens `path` or, where it is not there, does not fit or cannot be read, computes and writes it, on `threads`
  /// threads (0: all cores). Throws Error for an endless dataset, and when the file cannot be written.
  LabelCache(const Dataset& dataset, const std::string& dataset_key, const LabelOptions& options,
             const std::string& path, int threads = 0);
  ~LabelCache();
  LabelCache(const LabelCache&) = delete;
  LabelCache& operator=(const LabelCache&) = delete;

  /// Whether the sets were computed by this object rather than found in the file.
  bool computed() const { return computed_; }

  /// Those of an example of the dataset. Thread-safe. Throws Error naming file and example when the example is not the
  /// one that the sets were found for.
  std::vector<RankedSet> Sets(const Example& example) const;

 private:
  struct File;
  std::unique_ptr<File> file_;
  bool computed_ = false;
};

}  // namespace diffsac
