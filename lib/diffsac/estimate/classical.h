#pragma once

#include <string>

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/ransac/instances/instances.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"

namespace diffsac {

/// Options of the methods that search over minimal sets without learning.
struct ClassicalOptions {
  /// Minimal sets, of `instances.search: sequential` for each search: exactly so many with `consensus.stopping:
  /// budget`, at most so many otherwise (it stands for consensus.max_iterations). The exhaustive method takes every one
  /// of them, unless there are more than this: then it takes this many random ones, as its report's budget shows.
  int max_iterations = 1000;
  int search_threads = 1;   ///< Threads of one search, 0: all cores. Set by EstimateOptions, not by a key.
  bool exhaustive = false;  ///< Set by the method's type, not by a key.
  /// Where minimal sets come from. PROSAC on data without a quality samples uniformly.
  MinimalSamplerOptions sampling;
  ConsensusOptions consensus;
  InstanceSearchOptions instances;
  /// Whether there is a second search where the first one leaves doubts (second_search.h). Not for several models.
  bool search_again = false;
  /// F, where the images' sizes are known: whether they are photographs (PutCameraBehind).
  bool photographs = false;
};

/// MSAC, local optimisation, iterated refits (Chum, Matas, Kittler 2003), and the model's own nonlinear refinement
/// where it has one: the defaults of the row `lo_ransac`, which those of the others but `ransac` change.
ClassicalOptions LoRansacOptions(Task task);

/// Sample consensus without learning: the rows `ransac`, `lo_ransac`, `prosac`, `napsac`, `p_napsac`, `gc_ransac`,
/// `magsac_pp` and `exhaustive`, registered with their defaults in classical.cpp. Throws Error for wrong options.
class ClassicalEstimator : public RobustEstimator {
 public:
  explicit ClassicalEstimator(const ClassicalOptions& options);
  bool SearchesAgain() const override { return options_.search_again && !options_.instances.Several(); }

 private:
  Estimate DoRun(const NormalizedProblem& space, std::uint64_t seed) const override;

  ClassicalOptions options_;
};

}  // namespace diffsac
