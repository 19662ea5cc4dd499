#include "diffsac/estimators/static_overlay.h"

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
  if (estimate.status != Status::kOk || !estimate.structures.empty() || problem.task == Task::kHomography) return {};
  std::vector<int> moving = RowsFartherThan(problem, kStillReach * estimate.inlier_threshold);
  const auto inliers = std::count_if(estimate.inliers.begin(), estimate.inliers.end(), [](auto in) { return in != 0; });
  const auto still =
      inliers - std::count_if(moving.begin(), moving.end(), [&](int row) { return estimate.inliers[row] != 0; });
  if (2 * still < inliers || static_cast<int>(moving.size()) < kLeastMoving) moving.clear();
  return moving;
}

void PreferMoving(const std::vector<int>& rows, Estimate moving, Estimate* whole) {
  if (moving.status != Status::kOk || moving.MayBeChance()) return;
  const auto of_whole = std::count_if(rows.begin(), rows.end(), [&](int row) { return whole->inliers[row] != 0; });
  const auto of_moving = std::count(moving.inliers.begin(), moving.inliers.end(), 1);
  const auto still =
      std::count_if(whole->inliers.begin(), whole->inliers.end(), [](auto in) { return in != 0; }) - of_whole;
  if (of_moving < kLeastMoving || 2 * of_moving < 3 * of_whole || kMostStill * of_moving < still) return;
  const auto spread = [&](const auto& values, auto all) {
    for (std::size_t i = 0; i < values.size(); ++i) all[rows[i]] = values[i];
    return all;
  };
  moving.inliers = spread(moving.inliers, std::vector<std::uint8_t>(whole->inliers.size()));
  for (std::vector<float>* values : {&moving.inlier_probabilities, &moving.posteriors})
    if (!values->empty()) *values = spread(*values, std::vector<float>(whole->inliers.size()));
  for (std::vector<int>& set : moving.minimal_sets)
    for (int& row : set) row = rows[row];
  moving.report.hypotheses += whole->report.hypotheses;
  moving.report.draws += whole->report.draws;
  moving.report.ms_total += whole->report.ms_total;
  *whole = std::move(moving);
}

}  // namespace diffsac
