#include "diffsac/estimate/mirror_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

/// Whether neighbouring matches go round the other way in the second image: matches of a mirrored image do, wrong ones
/// as often as not.
bool GoesRoundOtherWay(const PointMatrix& points) {
  constexpr Eigen::Index kMost = 300;
  constexpr double kDeviations = 4.0;  // Of as many that go round by chance.
  constexpr double kLeastSine = 0.1;   // Points on a line go round by their noise.
  const Eigen::Index count = std::min(points.rows(), kMost);
  PointMatrix rows(count, 4);
  for (Eigen::Index i = 0; i < count; ++i) rows.row(i) = points.row(i * points.rows() / count);
  const auto side = [&](Eigen::Index i, Eigen::Index j, Eigen::Index k, int column) {
    const Eigen::RowVector2d a = rows.row(j).segment<2>(column) - rows.row(i).segment<2>(column),
                             b = rows.row(k).segment<2>(column) - rows.row(i).segment<2>(column);
    const double sine = (a.x() * b.y() - a.y() * b.x()) / (a.norm() * b.norm());
    return std::abs(sine) > kLeastSine ? sine : 0.0;
  };
  int seen = 0, turned = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::Index nearest[2] = {i, i};
    double least[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (Eigen::Index j = 0; j < count; ++j) {
      const double distance = (rows.row(j).head<2>() - rows.row(i).head<2>()).squaredNorm();
      if (j == i || !(distance < least[1])) continue;
      const bool first = distance < least[0];
      if (first) nearest[1] = nearest[0], least[1] = least[0];
      nearest[first ? 0 : 1] = j;
      least[first ? 0 : 1] = distance;
    }
    const double sides = side(i, nearest[0], nearest[1], 0) * side(i, nearest[0], nearest[1], 2);
    seen += sides < 0.0 || sides > 0.0;  // Not of a row that is not finite.
    turned += sides < 0.0;
  }
  return turned - 0.5 * seen > kDeviations * 0.5 * std::sqrt(seen);
}

std::ptrdiff_t InliersOf(const Estimate& estimate) {
  return std::count(estimate.inliers.begin(), estimate.inliers.end(), 1);
}

}  // namespace

/// About the upright line through the second principal point, so that K2 stays what it is.
Problem Mirrored(const Problem& problem) {
  Problem mirrored = problem;
  double middle = problem.size2.known() ? 0.5 * (problem.size2.width - 1) : problem.points.col(2).mean();
  if (problem.cameras) middle = problem.cameras->K2(0, 2);
  mirrored.points.col(2) = 2.0 * middle - problem.points.col(2).array();
  mirrored.scale_rotation_changes.resize(0, 2);  // Angles of mirrored keypoints are others.
  return mirrored;
}

bool MayBeMirrored(const NormalizedProblem& space, const Estimate& estimate) {
  const Problem& problem = space.problem();
  const bool searched = estimate.status == Status::kOk || estimate.status == Status::kNoModel;
  if (!searched || !IsTwoView(problem.task) || problem.points.cols() != 4) return false;
  if (!GoesRoundOtherWay(problem.points)) return false;
  return !estimate.IsSure() ||
         ParallaxOfEstimate(estimate.model, estimate.inliers, space).degeneracy != Degeneracy::kLine;
}

bool IsBetterMirrored(const Estimate& mirrored, const Estimate& estimate) {
  // A surface of which neighbouring points change sides is seen by no two cameras, however many fit a model.
  constexpr double kShare = 0.9;
  constexpr double kClear = -10.0;  // Of log10_nfa.
  return mirrored.status == Status::kOk && !mirrored.MayBeWrong() && mirrored.log10_nfa <= kClear &&
         static_cast<double>(InliersOf(mirrored)) >= kShare * static_cast<double>(InliersOf(estimate));
}

void SetMirrored(Estimate* estimate) {
  estimate->mirrored = true;
  estimate->log10_nfa = std::numeric_limits<double>::infinity();
  estimate->ambiguous_pose.reset();
  estimate->pose_covariance.reset();
}

}  // namespace diffsac
