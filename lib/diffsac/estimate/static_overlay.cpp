#include "diffsac/estimate/static_overlay.h"

#include <algorithm>
#include <utility>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// A scene has at least one match for so many of an overlay. Fewer are wrong matches of an image with itself.
constexpr int kMostStill = 20;

}  // namespace

std::vector<int> RowsFartherThan(const Problem& problem, double reach) {
  std::vector<int> rows;
  if (!IsTwoView(problem.task) || problem.points.cols() != 4) return rows;
  for (Eigen::Index i = 0; i < problem.points.rows(); ++i) {
    const auto match = problem.points.row(i);
    if (!((match.head<2>() - match.tail<2>()).norm() <= reach)) rows.push_back(static_cast<int>(i));
  }
  return rows;
}

std::vector<int> RowsThatMove(const Problem& problem, const Estimate& estimate) {
  if (estimate.status != Status::kOk || !estimate.instances.empty() || problem.task == Task::kHomography) return {};
  std::vector<int> moving = RowsFartherThan(problem, kStillReach * estimate.inlier_threshold);
  const auto inliers = std::count_if(estimate.inliers.begin(), estimate.inliers.end(), [](auto in) { return in != 0; });
  const auto still =
      inliers - std::count_if(moving.begin(), moving.end(), [&](int row) { return estimate.inliers[row] != 0; });
  if (2 * still < inliers || static_cast<int>(moving.size()) < kLeastMoving) moving.clear();
  return moving;
}

bool IsBetterMoving(const std::vector<int>& rows, const Estimate& moving, const Estimate& whole) {
  if (moving.status != Status::kOk || moving.MayBeChance()) return false;
  const auto of_whole = std::count_if(rows.begin(), rows.end(), [&](int row) { return whole.inliers[row] != 0; });
  const auto of_moving = std::count(moving.inliers.begin(), moving.inliers.end(), 1);
  const auto still =
      std::count_if(whole.inliers.begin(), whole.inliers.end(), [](auto in) { return in != 0; }) - of_whole;
  return of_moving >= kLeastMoving && 2 * of_moving >= 3 * of_whole && kMostStill * of_moving >= still;
}

void SpreadMoving(const std::vector<int>& rows, std::size_t count, Estimate* moving) {
  const auto spread = [&]<class Value>(std::vector<Value>* values) {
    std::vector<Value> all(values->empty() ? 0 : count);
    for (std::size_t i = 0; i < values->size(); ++i) all[rows[i]] = (*values)[i];
    *values = std::move(all);
  };
  spread(&moving->inliers);
  spread(&moving->inlier_probabilities);
  spread(&moving->posteriors);
  for (std::vector<int>& set : moving->minimal_sets)
    for (int& row : set) row = rows[row];
}

}  // namespace diffsac
