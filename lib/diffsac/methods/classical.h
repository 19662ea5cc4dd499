#pragma once

#include <memory>
#include <string>

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/core/options.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// Options of the methods that search over minimal sets without learning.
struct ClassicalOptions {
  /// Minimal sets. The exhaustive method takes every one of them, unless there are more than this: then it takes this
  /// many random ones, as its report's budget shows.
  int hypotheses = 1000;
  bool exhaustive = false;  ///< Set by the method's type, not by a key.
  ConsensusOptions consensus;
  void Bind(OptionsBinder& b);
};

/// Defaults of a type: `ransac` (inlier count, one least squares on the inliers), `lo_ransac` (MSAC, local
/// optimisation, iterated refits), `exhaustive` (every minimal set, MSAC, the best 5 refitted by expectation
/// maximisation). Throws Error for another type.
ClassicalOptions DefaultClassicalOptions(const std::string& type);

/// Sample consensus on uniformly random or on all minimal sets.
class ClassicalMethod : public Method {
 public:
  explicit ClassicalMethod(const ClassicalOptions& options) : options_(options) {}
  diffsac::Estimate Estimate(const Problem& problem, std::uint64_t seed) const override;

 private:
  ClassicalOptions options_;
};

/// A method of type "ransac", "lo_ransac", "exhaustive", "theil_sen" or "line_posterior" with the options in `config`; null for another
/// type. Throws Error (file, line, key) for a wrong option.
std::unique_ptr<Method> MakeClassicalMethod(const std::string& type, const Config& config, Task task);

}  // namespace diffsac
