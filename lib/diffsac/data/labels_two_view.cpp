#include "diffsac/data/labels_two_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "diffsac/consensus/hypothesis_source.h"
#include "diffsac/data/best_sets.h"
#include "diffsac/geometry/essential.h"
#include "diffsac/geometry/fundamental.h"
#include "diffsac/geometry/homography.h"
#include "diffsac/geometry/pose.h"

namespace diffsac {
namespace {

// Between two looks at the bound.
constexpr int kBlock = 64;

// The true inliers in the coordinates of the solver; the truncation in their unit.
struct TrueInliers {
  std::vector<int> index;  // of each in the problem
  PointMatrix points;
  Eigen::MatrixXd columns;  // the same, a coordinate a column
  double truncation = 0.0;
  double pixels = 1.0;  // in one unit

  int count() const { return static_cast<int>(index.size()); }
};

TrueInliers Collect(const Example& example, const LabelOptions& options) {
  const Problem& problem = example.problem;
  const auto& marks = example.truth.inliers;
  TrueInliers inliers;
  if (problem.points.cols() != 4) return inliers;
  for (int i = 0; i < static_cast<int>(std::min<std::size_t>(marks.size(), problem.points.rows())); ++i)
    if (marks[i] && problem.points.row(i).allFinite()) inliers.index.push_back(i);
  inliers.points = problem.points(inliers.index, Eigen::all);
  if (problem.task == Task::kEssential) {
    if (!problem.cameras) return {};
    inliers.points = NormalizedCoordinates(inliers.points, problem.cameras->K1, problem.cameras->K2);
    inliers.pixels = problem.cameras->MeanFocal();
  }
  inliers.columns = inliers.points;
  inliers.truncation = options.truncation_factor * problem.inlier_threshold / inliers.pixels;
  return inliers;
}

// The mean truncated distance, in the solver's unit; infinite once it is known to exceed `bound`.
template <class Model>
double MeanDistance(const TrueInliers& inliers, const Matrix3Parameters& model, double bound) {
  const int count = inliers.count();
  const double* columns[4];
  for (int k = 0; k < 4; ++k) columns[k] = inliers.columns.col(k).data();
  double distances[kBlock], sum = 0.0;
  for (int begin = 0; begin < count; begin += kBlock) {
    const int end = std::min(begin + kBlock, count);
    Model::Residuals(model, columns, begin, end, distances);
    // Written so that what is not a number counts as the truncation.
    for (int i = 0; i < end - begin; ++i) sum += distances[i] < inliers.truncation ? distances[i] : inliers.truncation;
    if (sum > bound * count) return std::numeric_limits<double>::infinity();
  }
  return sum / count;
}

template <class Model>
void Offer(const TrueInliers& inliers, const std::array<int, Model::kMinimalSize>& set,
           BestSets<Model::kMinimalSize>* best) {
  Matrix3Parameters models[Model::kMaxSolutions];
  const int solutions = Model::SolveMinimal(inliers.points, set.data(), models);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < solutions; ++i)
    if (models[i].allFinite())
      least = std::min(least, MeanDistance<Model>(inliers, models[i], std::min(least, best->bound())));
  if (least < std::numeric_limits<double>::infinity()) best->Offer(least, set);
}

// Uniform sets, or all where there are no more than `draws`.
std::vector<int> CandidateSets(int count, int size, int draws, const std::string& id) {
  return DrawAllOrSome(count, size, draws, Rng(0).Fork("label_sets/" + id));
}

template <class Model>
std::vector<RankedSet> FindOptimal(const Example& example, const LabelOptions& options, int count) {
  constexpr int kSize = Model::kMinimalSize;
  const TrueInliers inliers = Collect(example, options);
  if (inliers.count() < kSize || count <= 0) return {};
  BestSets<kSize> best(count);
  const std::vector<int> sets = CandidateSets(inliers.count(), kSize, options.draws, example.id);
  for (std::size_t first = 0; first + kSize <= sets.size(); first += kSize) {
    std::array<int, kSize> set;
    std::copy_n(sets.begin() + static_cast<std::ptrdiff_t>(first), kSize, set.begin());
    Offer<Model>(inliers, set, &best);
  }
  std::vector<RankedSet> ranked;
  for (const auto& entry : best.entries()) {
    RankedSet set;
    for (int member : entry.set) set.points.push_back(inliers.index[member]);
    set.distance = entry.cost * inliers.pixels;
    ranked.push_back(std::move(set));
  }
  return ranked;
}

}  // namespace

std::vector<RankedSet> OptimalTwoViewSets(const Example& example, const LabelOptions& options, int count) {
  if (example.problem.task == Task::kHomography) return FindOptimal<Homography>(example, options, count);
  if (example.problem.task == Task::kEssential) return FindOptimal<Essential>(example, options, count);
  return options.fundamental_points == 8 ? FindOptimal<Fundamental8>(example, options, count)
                                         : FindOptimal<Fundamental>(example, options, count);
}

}  // namespace diffsac
