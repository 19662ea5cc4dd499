#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "diffsac/estimate/estimate_options.h"
#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// What the functions of diffsac.h run, made once for any number of problems of a task:
///
/// ```
/// const diffsac::Estimator estimator(diffsac::Task::kEssential);
/// for (const diffsac::Problem& problem : problems) Use(estimator.Run(problem));
/// ```
///
/// With the first problem that needs one a network is found and read; it, the checked options and the memory of earlier
/// runs are kept as long as the Estimator. Many threads may call it at once.
class Estimator {
 public:
  /// several: for several models of one kind in the same points. The seed of `options` is not used. Throws Error as
  /// EstimateOptions::Check does.
  explicit Estimator(Task task, const EstimateOptions& options = {}, bool several = false);

  /// RobustEstimator::Run of the recommended estimator for what is known of the matches (ratios, scores, nothing).
  /// Throws Error for a problem of another task, and where a network is not found.
  Estimate Run(const Problem& problem, std::uint64_t seed = 0) const;
  /// The estimator of matches without ratios and scores; without a network where that is not found.
  const RobustEstimator& WithoutScores() const;

 private:
  enum Known { kNothing, kRatios, kScores };  ///< Of the matches.
  const RobustEstimator& For(Known known) const;
  std::shared_ptr<const RobustEstimator> Make(Known known) const;
  std::shared_ptr<const RobustEstimator> Made(std::shared_ptr<RobustEstimator> made, Known known) const;
  /// By what is known of its matches.
  const RobustEstimator& For(const Problem& problem) const;

  Task task_;
  EstimateOptions options_;
  bool several_;
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const RobustEstimator> made_[3];  ///< By what is known.
};

/// The Estimator of these, of those that were asked for last.
std::shared_ptr<const Estimator> CachedEstimator(Task task, const EstimateOptions& options, bool several = false);

}  // namespace diffsac
