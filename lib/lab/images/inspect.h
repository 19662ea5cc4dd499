#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

namespace diffsac {

/// Smallest, 10 %, median, 90 % and largest of some values.
struct Spread {
  double min = 0.0, p10 = 0.0, median = 0.0, p90 = 0.0, max = 0.0;
};

/// What stands in a folder of correspondences.
struct SceneSummary {
  std::string scene;
  int pairs = 0;
  Spread matches;                     ///< Correspondences a pair.
  bool has_truth = false;             ///< Whether distances to a true model are known.
  double mean_share = 0.0;            ///< Of matches within the threshold of the truth, mean over pairs.
  Spread share;                       ///< The same over pairs.
  double labelled_share = -1.0;       ///< Of matches labelled as inliers, mean over pairs; -1 without labels.
  std::int64_t repeats = 0;           ///< Correspondences equal to an earlier one of their pair.
  std::string contents;               ///< "ratio K pose E F H labels": what the pairs have.
  std::vector<std::string> problems;  ///< One line each, naming the pair.
};

/// Reads all pairs of one scene. `threshold_px` is the distance that counts as an inlier. Checks: no value is infinite
/// or no number, points are in the images (within 10 % of their size, since lens distortion was taken out), ratios in
/// [0, 1], E and F agree with the poses and K, at least one match near the truth. Stops early when `stop` turns true.
/// Throws Error for files that cannot be read.
SceneSummary InspectScene(const std::string& folder, double threshold_px, const std::atomic<bool>& stop);

/// A table, a row a scene, then the problems that were found.
std::string SummaryText(const std::vector<SceneSummary>& summaries, double threshold_px);

}  // namespace diffsac
