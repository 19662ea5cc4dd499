#include "diffsac/estimators/mirror_check.h"

#include <algorithm>
#include <limits>

#include "diffsac/estimators/score_check.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// About the upright line through the second principal point, so that K2 stays what it is.
Problem Mirrored(const Problem& problem) {
  Problem mirrored = problem;
  double middle = problem.size2.known() ? 0.5 * (problem.size2.width - 1) : problem.points.col(2).mean();
  if (problem.cameras) middle = problem.cameras->K2(0, 2);
  mirrored.points.col(2) = 2.0 * middle - problem.points.col(2).array();
  mirrored.similarities.resize(0, 2);  // Angles of mirrored keypoints are others.
  return mirrored;
}

std::ptrdiff_t InliersOf(const Estimate& estimate) {
  return std::count(estimate.inliers.begin(), estimate.inliers.end(), 1);
}

}  // namespace

void CheckMirrored(const Problem& problem, const std::function<Estimate(const Problem&)>& search, Estimate* estimate) {
  constexpr int kTimes = 2;         // As many inliers.
  constexpr double kClear = -10.0;  // Of log_false_alarms.
  const bool searched = estimate->status == Status::kOk || estimate->status == Status::kNoModel;
  if (!searched || !IsTwoView(problem.task) || problem.points.cols() != 4) return;
  if (estimate->status == Status::kOk && !estimate->MayBeWrong()) return;
  const Estimate mirrored = search(Mirrored(problem));
  AddCost(mirrored.report, &estimate->report);
  if (mirrored.status != Status::kOk || mirrored.MayBeWrong() || mirrored.log_false_alarms > kClear ||
      InliersOf(mirrored) < kTimes * InliersOf(*estimate))
    return;
  estimate->mirrored = true;
  estimate->log_false_alarms = std::numeric_limits<double>::infinity();
  estimate->translation = Translation::kNotTested;
  estimate->turn.reset();
  estimate->other_pose.reset();
  estimate->pose_covariance.reset();
}

}  // namespace diffsac
