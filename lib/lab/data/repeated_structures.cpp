#include "lab/data/repeated_structures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

constexpr int kMostGroups = 3;
constexpr double kLeastShare = 0.05, kMostShare = 0.3;
constexpr double kLeastMoved = 0.5;
constexpr double kLeastStep = 0.5, kMostStep = 3.0;
constexpr double kScale = 0.05;
// Fewer than this are no group.
constexpr int kLeastGroup = 4;

struct Members {
  std::vector<int> inliers, outliers;
};

Members Split(const GroundTruth& truth) {
  Members members;
  for (std::size_t i = 0; i < truth.inliers.size(); ++i)
    (truth.inliers[i] ? members.inliers : members.outliers).push_back(static_cast<int>(i));
  return members;
}

// The `count` inliers nearest to a random one in image 1.
std::vector<int> Neighbourhood(const PointMatrix& points, std::vector<int> inliers, int count, Rng& rng) {
  const Eigen::RowVector2d centre = points.row(inliers[rng.Below(inliers.size())]).head<2>();
  const auto distance = [&](int i) { return (points.row(i).head<2>() - centre).squaredNorm(); };
  std::nth_element(inliers.begin(), inliers.begin() + (count - 1), inliers.end(), [&](int a, int b) {
    const double da = distance(a), db = distance(b);
    return da < db || (da == db && a < b);
  });
  inliers.resize(count);
  std::sort(inliers.begin(), inliers.end());
  return inliers;
}

bool Inside(const Eigen::RowVector2d& x, const ImageSize& size) {
  return !size.known() || (x[0] >= 0.0 && x[1] >= 0.0 && x[0] < size.width && x[1] < size.height);
}

// Whether match i obeys the true model.
bool Obeys(const Example& example, int i) {
  const Problem& problem = example.problem;
  return DispatchDescription(problem.task, [&]<class Description>() {
    if constexpr (Description::kTwoView) {
      const auto model = Description::PixelModel(example.truth.model, problem);
      return Description::PixelResidual(model, problem.points.row(i).data()) <= problem.inlier_threshold;
    } else {
      return false;
    }
  });
}

// Moves some of the group's members in image 2 and marks them.
void Move(const std::vector<int>& group, const ImageSize& size, Rng& rng, PointMatrix* points,
          std::vector<char>* moved) {
  Eigen::RowVector2d centre = Eigen::RowVector2d::Zero();
  for (const int i : group) centre += points->row(i).tail<2>() / static_cast<double>(group.size());
  double extent = 0.0;
  for (const int i : group)
    extent += (points->row(i).tail<2>() - centre).squaredNorm() / static_cast<double>(group.size());
  const double length = rng.Uniform(kLeastStep, kMostStep) * std::sqrt(extent);
  const double angle = rng.Uniform(0.0, 2.0 * std::numbers::pi);
  const Eigen::RowVector2d step = length * Eigen::RowVector2d(std::cos(angle), std::sin(angle));
  const double scale = rng.Uniform(1.0 - kScale, 1.0 + kScale);
  const double share = rng.Uniform(kLeastMoved, 1.0);
  for (const int i : group) {
    const bool chosen = rng.Uniform() < share;
    const Eigen::RowVector2d to = centre + step + scale * (points->row(i).tail<2>() - centre);
    if (!chosen || (*moved)[i] || !Inside(to, size)) continue;
    points->row(i).tail<2>() = to;
    (*moved)[i] = 1;
  }
}

}  // namespace

std::vector<char> MoveGroups(Rng rng, Example* example) {
  Problem& problem = example->problem;
  const auto count = static_cast<std::size_t>(problem.points.rows());
  std::vector<char> moved(count, 0);
  const bool known = example->truth.inliers.size() == count && example->truth.model.size() > 0;
  if (!known || !HasItsNeeds(problem)) return moved;
  const Members members = Split(example->truth);
  const int inliers = static_cast<int>(members.inliers.size());
  if (inliers < kLeastGroup) return moved;
  const int groups = 1 + static_cast<int>(rng.Below(kMostGroups));
  for (int k = 0; k < groups; ++k) {
    const int size = static_cast<int>(std::lround(rng.Uniform(kLeastShare, kMostShare) * inliers));
    if (size < kLeastGroup) continue;
    Move(Neighbourhood(problem.points, members.inliers, size, rng), problem.size2, rng, &problem.points, &moved);
  }
  const bool ratios = problem.snn_ratio.size() == problem.points.rows() && !members.outliers.empty();
  for (const int i : members.inliers) {
    if (!moved[i]) continue;
    const bool taken = rng.Uniform() < 0.5;
    const int other = ratios ? members.outliers[rng.Below(members.outliers.size())] : 0;
    if (ratios && taken) problem.snn_ratio[i] = problem.snn_ratio[other];
    example->truth.inliers[i] = Obeys(*example, i);
  }
  return moved;
}

}  // namespace diffsac
