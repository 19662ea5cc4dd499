#include "diffsac/estimate/error_probability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// The share of the pairs of neighbours in the second image that are neighbours in the first one: near, in the first
/// image's extent, or hardly farther than in the second. Wrong matches that fit epipolar geometry are so by chance.
double Coherence(const PointMatrix& inliers) {
  constexpr int kMost = 200, kNeighbours = 5;
  constexpr double kStretch = 4.0, kNear = 0.02;
  const auto found = static_cast<int>(inliers.rows());
  const int count = std::min(found, kMost);
  if (count <= kNeighbours) return 0.0;
  PointMatrix rows(count, 4);
  for (int i = 0; i < count; ++i) rows.row(i) = inliers.row(static_cast<std::int64_t>(i) * found / count);
  const double extent = (rows.leftCols(2).colwise().maxCoeff() - rows.leftCols(2).colwise().minCoeff()).maxCoeff();
  int near = 0;
  std::vector<int> order(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const Eigen::VectorXd second = (rows.rightCols(2).rowwise() - rows.row(i).tail<2>()).rowwise().norm();
    std::iota(order.begin(), order.end(), 0);
    std::swap(order[0], order[static_cast<std::size_t>(i)]);
    std::nth_element(order.begin() + 1, order.begin() + kNeighbours, order.end(),
                     [&](int a, int b) { return second[a] != second[b] ? second[a] < second[b] : a < b; });
    for (int k = 1; k <= kNeighbours; ++k) {
      const int j = order[static_cast<std::size_t>(k)];
      near += (rows.row(i).head<2>() - rows.row(j).head<2>()).norm() < kStretch * second[j] + kNear * extent;
    }
  }
  return near / static_cast<double>(kNeighbours * count);
}

/// Of log inliers, their share, log of how many the network expected for each, coherence, and F.
struct Logistic {
  double constant, inliers, share, expected, coherence, fundamental;
};
constexpr Logistic kWithNetwork = {21.36, -1.980, 5.095, 2.937, -16.98, 1.380},
                   kWithout = {23.33, -1.929, 0.586, 0.0, -17.98, 1.218};

}  // namespace

double ErrorProbability(const Problem& problem, const Estimate& estimate) {
  const bool fundamental = problem.task == Task::kFundamental;
  if (estimate.status != Status::kOk || !estimate.instances.empty() ||
      !(fundamental || problem.task == Task::kEssential))
    return std::numeric_limits<double>::quiet_NaN();
  std::vector<int> rows;
  for (std::size_t i = 0; i < estimate.inliers.size(); ++i)
    if (estimate.inliers[i] != 0) rows.push_back(static_cast<int>(i));
  const double inliers = std::max(1.0, static_cast<double>(rows.size()));
  const auto& network = estimate.inlier_probabilities;
  const Logistic& by = network.empty() ? kWithout : kWithNetwork;
  const double expected = std::accumulate(network.begin(), network.end(), 1.0);
  const double logit =
      by.constant + by.inliers * std::log(inliers) + by.share * inliers / static_cast<double>(problem.points.rows()) +
      by.expected * std::log(expected / inliers) + by.coherence * Coherence(problem.points(rows, Eigen::all)) +
      (fundamental ? by.fundamental : 0.0);
  return 1.0 / (1.0 + std::exp(-logit));
}

}  // namespace diffsac
