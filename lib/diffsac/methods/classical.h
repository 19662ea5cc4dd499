#pragma once

#include <string>

#include "diffsac/consensus/make_source.h"
#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/core/options.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// Options of the methods that search over minimal sets without learning.
struct ClassicalOptions {
  /// Minimal sets: exactly so many with `consensus.stopping: budget`, at most so many otherwise (it stands for
  /// consensus.max_iterations). The exhaustive method takes every one of them, unless there are more than this: then it
  /// takes this many random ones, as its report's budget shows.
  int hypotheses = 1000;
  bool exhaustive = false;  ///< Set by the method's type, not by a key.
  /// Where minimal sets come from. PROSAC on data without a quality samples uniformly.
  SourceOptions sampling;
  ConsensusOptions consensus;
  void Bind(OptionsBinder& b);
};

/// Defaults of a type. Two-view tasks end with the model's own nonlinear refinement except in `ransac`.
///   ransac      inlier count, one least squares on the inliers
///   lo_ransac   MSAC, local optimisation, iterated refits (Chum, Matas, Kittler 2003)
///   prosac      the same with sets in the order of quality (Chum, Matas 2005)
///   napsac, p_napsac   the same with sets from neighbourhoods (Torr et al. 2002; Barath et al. 2020)
///   gc_ransac   the same with graph-cut local optimisation (Barath, Matas 2018)
///   magsac_pp   MAGSAC++ score, reweighted local optimisation and refit (Barath et al. 2020)
///   exhaustive  every minimal set, MSAC, the best 5 refitted by expectation maximisation
/// Throws Error for another type, and of exhaustive for a task of two views.
ClassicalOptions DefaultClassicalOptions(const std::string& type, Task task);

/// Sample consensus without learning.
class ClassicalMethod : public Method {
 public:
  explicit ClassicalMethod(const ClassicalOptions& options) : options_(options) {}
  diffsac::Estimate Estimate(const Problem& problem, std::uint64_t seed) const override;

 private:
  ClassicalOptions options_;
};

}  // namespace diffsac
