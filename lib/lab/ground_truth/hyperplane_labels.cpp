#include "lab/ground_truth/labels.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "diffsac/ransac/samplers/minimal_sampler.h"
#include "lab/ground_truth/best_sets.h"

namespace diffsac {
namespace {

// The true inliers in a frame of the ground-truth model: origin at the mean of their projections onto it, the last axis
// along its normal, the others along the projections' principal axes. There the moments of the projections are diagonal
// and a candidate's distance to the ground truth needs a handful of products.
template <int D>
struct TruthFrame {
  using Vector = Eigen::Matrix<double, D, 1>;
  std::vector<int> index;                    // of each inlier in the problem
  std::vector<Vector> local;                 // its coordinates in the frame
  Eigen::Matrix<double, D - 1, 1> variance;  // of the projections along the principal axes
};

// Two or one orthonormal directions within the hyperplane.
Eigen::Matrix<double, 2, 1> TangentBasis(const Eigen::Vector2d& n) { return {-n[1], n[0]}; }
Eigen::Matrix<double, 3, 2> TangentBasis(const Eigen::Vector3d& n) {
  const Eigen::Vector3d helper = std::abs(n[0]) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = n.cross(helper).normalized();
  basis.col(1) = n.cross(basis.col(0));
  return basis;
}

template <int D>
TruthFrame<D> MakeFrame(const Example& example) {
  TruthFrame<D> frame;
  const auto& points = example.problem.points;
  const auto& inliers = example.truth.inliers;
  if (example.truth.model.size() != D + 1 || points.cols() != D) return frame;
  for (int i = 0; i < static_cast<int>(std::min<std::size_t>(inliers.size(), points.rows())); ++i)
    if (inliers[i] && points.row(i).allFinite()) frame.index.push_back(i);
  const auto count = static_cast<int>(frame.index.size());
  if (count < D) return frame;

  const Eigen::Matrix<double, D, 1> normal = example.truth.model.head<D>();
  const auto tangent = TangentBasis(normal);
  Eigen::Matrix<double, Eigen::Dynamic, D - 1> flat(count, D - 1);
  for (int i = 0; i < count; ++i) flat.row(i) = points.row(frame.index[i]) * tangent;
  const Eigen::Matrix<double, 1, D - 1> mean = flat.colwise().mean();
  flat.rowwise() -= mean;
  const Eigen::Matrix<double, D - 1, D - 1> covariance = flat.transpose() * flat / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, D - 1, D - 1>> solver(covariance);
  frame.variance = solver.eigenvalues().cwiseMax(0.0);
  const Eigen::Matrix<double, Eigen::Dynamic, D - 1> rotated = flat * solver.eigenvectors();
  frame.local.resize(count);
  for (int i = 0; i < count; ++i) {
    frame.local[i].template head<D - 1>() = rotated.row(i).transpose();
    frame.local[i][D - 1] = points.row(frame.index[i]).dot(normal) + example.truth.model[D];
  }
  return frame;
}

// Square of the distance between the ground truth and the candidate with normal m (any length) through p, in the frame:
// the mean over the projections q of (m·q − m·p)² / |m|², whose cross terms vanish because the projections are centred.
// Infinite for a degenerate candidate.
template <int D>
double SquaredDistance(const TruthFrame<D>& frame, const Eigen::Matrix<double, D, 1>& m,
                       const Eigen::Matrix<double, D, 1>& p) {
  const double length = m.squaredNorm();
  const double at_origin = m.dot(p);
  const double spread = m.template head<D - 1>().cwiseAbs2().dot(frame.variance);
  const double squared = (spread + at_origin * at_origin) / length;
  return std::isfinite(squared) ? squared : std::numeric_limits<double>::infinity();
}

template <int D>
double SquaredDistanceOfSet(const TruthFrame<D>& frame, const std::array<int, D>& set) {
  const auto& a = frame.local[set[0]];
  if constexpr (D == 2) {
    const Eigen::Vector2d direction = frame.local[set[1]] - a;
    return SquaredDistance<2>(frame, {-direction[1], direction[0]}, a);
  } else {
    const Eigen::Vector3d u = frame.local[set[1]] - a, v = frame.local[set[2]] - a;
    const Eigen::Vector3d normal = u.cross(v);
    // Collinear up to rounding: the normal's direction would be noise.
    if (normal.squaredNorm() <= 1e-20 * u.squaredNorm() * v.squaredNorm())
      return std::numeric_limits<double>::infinity();
    return SquaredDistance<3>(frame, normal, a);
  }
}

template <int D>
void Offer(const TruthFrame<D>& frame, const std::array<int, D>& set, BestSets<D>* best) {
  const double cost = SquaredDistanceOfSet<D>(frame, set);
  if (cost < std::numeric_limits<double>::infinity()) best->Offer(cost, set);
}

// All triplets out of `members` (ascending).
void SearchAllTriplets(const TruthFrame<3>& frame, const std::vector<int>& members, BestSets<3>* best) {
  const auto count = static_cast<int>(members.size());
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j)
      for (int k = j + 1; k < count; ++k) Offer<3>(frame, {members[i], members[j], members[k]}, best);
}

// The `count` inliers that alone tilt or shift a plane least: height above the ground truth over leverage, where
// leverage is the distance from the centre in standard deviations of the projections (a far point tilts less).
std::vector<int> PromisingMembers(const TruthFrame<3>& frame, int count) {
  const auto total = static_cast<int>(frame.local.size());
  const Eigen::Array2d variance = frame.variance.array().max(1e-300);
  std::vector<double> key(total);
  for (int i = 0; i < total; ++i) {
    const double leverage = (frame.local[i].head<2>().array().square() / variance).sum();
    key[i] = std::abs(frame.local[i][2]) / std::sqrt(1.0 + leverage);
  }
  std::vector<int> members(total);
  std::iota(members.begin(), members.end(), 0);
  std::nth_element(members.begin(), members.begin() + count - 1, members.end(),
                   [&](int a, int b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
  members.resize(count);
  std::sort(members.begin(), members.end());
  return members;
}

// Within the budget: all triplets of the most promising inliers.
void SearchBounded(const TruthFrame<3>& frame, int budget, BestSets<3>* best) {
  const auto total = static_cast<int>(frame.index.size());
  int chosen = 3;
  while (chosen < total && Combinations(chosen + 1, 3) <= budget) ++chosen;
  SearchAllTriplets(frame, PromisingMembers(frame, chosen), best);
}

void Search(const TruthFrame<2>& frame, const LabelOptions&, BestSets<2>* best) {
  const auto count = static_cast<int>(frame.index.size());
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j) Offer<2>(frame, {i, j}, best);
}

void Search(const TruthFrame<3>& frame, const LabelOptions& options, BestSets<3>* best) {
  const auto count = static_cast<int>(frame.index.size());
  if (Combinations(count, 3) > options.search_budget) return SearchBounded(frame, options.search_budget, best);
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  SearchAllTriplets(frame, all, best);
}

}  // namespace

template <int D>
std::vector<RankedSet> OptimalHyperplaneSets(const Example& example, const LabelOptions& options, int count) {
  const TruthFrame<D> frame = MakeFrame<D>(example);
  if (frame.local.empty() || count <= 0) return {};
  BestSets<D> best(count);
  Search(frame, options, &best);
  std::vector<RankedSet> ranked;
  for (const auto& entry : best.entries()) {
    RankedSet set;
    for (int member : entry.set) set.points.push_back(frame.index[member]);
    set.distance = std::sqrt(entry.cost);
    ranked.push_back(std::move(set));
  }
  return ranked;
}

template std::vector<RankedSet> OptimalHyperplaneSets<2>(const Example&, const LabelOptions&, int);
template std::vector<RankedSet> OptimalHyperplaneSets<3>(const Example&, const LabelOptions&, int);

}  // namespace diffsac
