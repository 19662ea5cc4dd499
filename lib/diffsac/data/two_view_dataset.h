#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/data/problem.h"
#include "diffsac/data/two_view.h"

namespace diffsac {

/// Correspondence files (data/correspondence_files.h) as a dataset.
struct CorrespondencesOptions {
  /// Folders of correspondence files, or folders of such folders; a scene each.
  std::vector<std::string> paths;
  std::string task = "fundamental";   ///< "homography" | "fundamental" | "essential"
  double inlier_threshold_px = 1.0;   ///< ε, linear.
  /// Only matches whose ratio is at most this; 1 keeps all, and so does data without ratios.
  double max_ratio = 1.0;
  /// At most so many matches; 0 keeps all.
  int max_points = 0;
  /// Which: "best" by ratio (the first where there is none) | "random".
  std::string cap = "best";
  /// Matches in random order. This and `cap: random` depend on the pair's scene and id alone.
  bool shuffle_points = false;
  /// Only pairs with at least so many matches left.
  int min_points = 0;
  /// At most so many pairs of a scene, evenly spread; 0 keeps all.
  int max_pairs = 0;
  /// The part of each scene's pairs, in the order of their names, that is used: [0, 1] all, [0.8, 1] the last fifth. The
  /// same scene can train and validate.
  Range part = {0.0, 1.0};
  /// For training: inliers and models come from the truth refined on the matches near it (data/refined_truth.h),
  /// truncated at so many pixels; 0 takes the source's truth.
  double refine_truth_px = 0.0;
  /// Task homography, pairs that have a pose but no homography: the truth is that of most true matches
  /// (data/dominant_plane.h); where there is none, the example has no true model and no inliers.
  bool dominant_plane = false;
  /// Whether descriptors.h5 is read where it is there.
  bool descriptors = false;
  /// Standard deviation of the normal noise that is added to each descriptor's values, in multiples of their root mean
  /// square; decided by the pair's scene and id.
  double descriptor_noise = 0.0;
  void Bind(OptionsBinder& b);
};

/// Reads the pairs once. Throws Error naming the folder or file: nothing found, a pair that cannot be read, essential
/// matrices asked for where a pair has no calibration.
std::unique_ptr<Dataset> MakeCorrespondences(const CorrespondencesOptions& options);

/// One pair as an example of `task`; matches are filtered as the options say. Ground truth that is not there stays empty.
Example ToExample(const TwoViewExample& pair, Task task, const CorrespondencesOptions& options);

/// `count` of `size` positions, evenly spread; all of them for count 0.
std::vector<std::int64_t> EvenlySpread(std::int64_t size, int count);

}  // namespace diffsac
