#include "lab/data/pair_check.h"

#include <algorithm>

#include "diffsac/core/status.h"
#include "lab/data/finite_points.h"
#include "lab/ground_truth/pair_truth.h"
#include "lab/options/config_tree.h"

namespace diffsac {
namespace {

std::string Of(std::int64_t count, std::int64_t all) { return std::to_string(count) + " of " + std::to_string(all); }

}  // namespace

void PairCheck::Add(const Example& pair) {
  pairs_ += 1;
  const GroundTruth& truth = pair.truth;
  if (options_.filter.ratios) {
    ratios_ += pair.problem.snn_ratio.size();
    // Rounded from single precision.
    bad_ratios_ += (pair.problem.snn_ratio.array() < 0.0 || pair.problem.snn_ratio.array() > 1.0 + 1e-6).count();
  }
  const bool turn = truth.motion && truth.motion->translation.norm() < 1e-9 && options_.task != Task::kHomography;
  without_baseline_ += turn;
  // Nothing is near the lines of a turn, which has none.
  if (truth.assignment.empty() && pair.problem.points.rows() > 0 && !turn) AddNear(pair);
}

void PairCheck::AddNear(const Example& pair) {
  const bool plane = options_.task == Task::kHomography;
  // A pose says nothing of a homography.
  if (plane ? !pair.truth.homography : !pair.truth.fundamental) return;
  const Eigen::VectorXd distances = TruthDistances(pair.problem, pair.truth);
  if (distances.size() == 0) return;
  const auto near = (distances.array() <= options_.inlier_threshold_px).count();
  measured_ += 1;
  without_right_ += near == 0;
  near_ += near;
  matches_ += distances.size();
  files_ = pair.truth.homography ? "Hgt.h5" : pair.truth.motion ? "R.h5, T.h5 or K1_K2.h5" : "Fgt.h5, or Egt.h5,";
}

void PairCheck::Tell(const std::string& folder) const {
  if (bad_ratios_ > 0)
    throw Error(folder + "/match_conf.h5: " + Of(bad_ratios_, ratios_) + " ratios are not in [0, 1]");
  if (without_baseline_ > 0)
    WarnOnce(folder + "/T.h5: " + Of(without_baseline_, pairs_) +
             " pairs have no baseline: no direction of t is right there, and any counts as 0 degrees off");
  // Fewer than any data has that somebody could learn from: chance alone gives about half a per cent, a truth that is
  // transposed up to 3.
  constexpr double kLeastShare = 0.03, kLeastOfPoints = 0.01;
  const std::string near = " within " + DoubleText(options_.inlier_threshold_px) + " px of the truth";
  const double share = static_cast<double>(near_) / static_cast<double>(std::max<std::int64_t>(matches_, 1));
  if (matches_ > 0 && share < (options_.task == Task::kHomography ? kLeastOfPoints : kLeastShare))
    WarnOnce(folder + ": of " + std::to_string(matches_) + " matches " + std::to_string(near_) + " are" + near + ": " +
             files_ + " may be of another convention (transposed, inverted), or of other images");
  else if (5 * without_right_ > measured_)
    WarnOnce(folder + ": " + Of(without_right_, measured_) + " pairs have no match" + near);
}

void WarnOfMissingTruth(const Dataset& dataset) {
  constexpr int kLookedAt = 16;
  if (dataset.size() <= 0 || !IsTwoView(dataset.task())) return;
  for (const std::int64_t i : EvenlySpread(dataset.size(), kLookedAt)) {
    const Example pair = dataset.Get(static_cast<std::uint64_t>(i));
    const GroundTruth& truth = pair.truth;
    const std::string folder = dataset.FolderOf(pair.scene);
    if (folder.empty() || truth.model.size() > 0 || truth.pose || !truth.inliers.empty() || !truth.instances.empty())
      continue;
    WarnOnce(folder + ": no truth of task " + ToString(dataset.task()) +
             " (R.h5 and T.h5, Egt.h5, Fgt.h5, Hgt.h5 or labels.h5): errors are not measured");
  }
}

}  // namespace diffsac
