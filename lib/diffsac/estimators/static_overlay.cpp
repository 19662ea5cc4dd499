#include "diffsac/estimators/static_overlay.h"

#include <algorithm>
#include <utility>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// Fewer that move prove nothing.
constexpr int kLeastMoving = 12;

}  // namespace

std::vector<int> RowsThatMove(const Problem& problem, const Estimate& estimate) {
  constexpr double kReach = 2.0;  // In thresholds of an inlier's distance from its line, which has one dimension less.
  if (estimate.status != Status::kOk || !estimate.structures.empty() || !IsTwoView(problem.task) ||
      problem.task == Task::kHomography)
    return {};
  std::vector<int> moving;
  int inliers = 0, still = 0;
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i) {
    const auto match = problem.points.row(static_cast<Eigen::Index>(i));
    const bool moves = !((match.head<2>() - match.tail<2>()).norm() <= kReach * estimate.inlier_threshold);
    if (moves) moving.push_back(static_cast<int>(i));
    inliers += estimate.inliers[i] != 0;
    still += estimate.inliers[i] != 0 && !moves;
  }
  if (2 * still < inliers || static_cast<int>(moving.size()) < kLeastMoving) moving.clear();
  return moving;
}

void PreferMoving(const std::vector<int>& rows, Estimate moving, Estimate* whole) {
  if (moving.status != Status::kOk || moving.MayBeChance()) return;
  const auto of_whole = std::count_if(rows.begin(), rows.end(), [&](int row) { return whole->inliers[row] != 0; });
  const auto of_moving = std::count(moving.inliers.begin(), moving.inliers.end(), 1);
  if (of_moving < kLeastMoving || 2 * of_moving < 3 * of_whole) return;
  const auto spread = [&](const auto& values, auto all) {
    for (std::size_t i = 0; i < values.size(); ++i) all[rows[i]] = values[i];
    return all;
  };
  moving.inliers = spread(moving.inliers, std::vector<std::uint8_t>(whole->inliers.size()));
  if (!moving.inlier_probabilities.empty())
    moving.inlier_probabilities = spread(moving.inlier_probabilities, std::vector<float>(whole->inliers.size()));
  for (std::vector<int>& set : moving.minimal_sets)
    for (int& row : set) row = rows[row];
  moving.report.hypotheses += whole->report.hypotheses;
  moving.report.draws += whole->report.draws;
  moving.report.ms_total += whole->report.ms_total;
  *whole = std::move(moving);
}

}  // namespace diffsac
