#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "diffsac/core/enum_names.h"
#include "diffsac/estimators/robust_estimator.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// What is known of the cameras of two images without calibration.
enum class Cameras {
  kPhotographs,  ///< As most have them: square pixels, a principal point near the image's middle, a usual focal length.
  kUnknown,      ///< Nothing: pixels may be of any shape.
};
template <>
inline constexpr auto kEnumNames<Cameras> = NamesOf<Cameras>({{Cameras::kPhotographs, "photographs"},
                                                              {Cameras::kUnknown, "unknown"}});

/// What every estimate may be told.
struct EstimateOptions {
  static constexpr int kMostIterations = 10'000'000;  ///< Of max_iterations.
  /// Up to so many minimal samples are drawn (0: what is recommended, 1000 or, for lines and planes, 420); fewer where
  /// the search is confident earlier.
  int max_iterations = 0;
  /// Two views: whether a network says where to draw; without one PROSAC draws by the ratios, or uniformly. Vanishing
  /// points: whether a network chooses them; without one those of most segments are taken, by length. Of matches with
  /// scores there is no network: it has learned what ratios say.
  bool use_network = true;
  /// Where models are: a folder like the project's models/. Empty: $DIFFSAC_MODELS, then where they were installed.
  std::string models_folder = {};
  /// F: what is known of cameras where the images' sizes are. What matches contradict (a crop, say) counts little.
  Cameras cameras = Cameras::kPhotographs;
  std::uint64_t seed = 0;  ///< Of all that is drawn.
  /// Throws Error naming the field and what was expected.
  void Check() const;
};

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

 private:
  enum Known { kNothing, kRatios, kScores };  ///< Of the matches.
  const RobustEstimator& For(Known known) const;
  std::shared_ptr<const RobustEstimator> Make(Known known) const;
  /// By what is known of its matches.
  const RobustEstimator& For(const Problem& problem) const;

  Task task_;
  EstimateOptions options_;
  bool several_;
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const RobustEstimator> made_[3];  ///< By what is known.
};

/// The Estimator of these, of those that were asked for last.
std::shared_ptr<const Estimator> KeptEstimator(Task task, const EstimateOptions& options, bool several = false);

}  // namespace diffsac
