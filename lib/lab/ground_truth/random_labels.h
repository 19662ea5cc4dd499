#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "diffsac/geometry/model.h"
#include "diffsac/problem/normalized_problem.h"
#include "lab/ground_truth/best_sets.h"
#include "lab/ground_truth/labels.h"

namespace diffsac {
namespace random_labels_internal {

/// The true inliers in the coordinates of the solver; the truncation in their unit.
struct TrueInliers {
  std::vector<int> index;  // of each in the problem
  PointMatrix points;
  Eigen::MatrixXd columns;  // the same, a coordinate a column
  double truncation = 0.0;
  double unit = 1.0;  // of the data's unit in one of these

  int count() const { return static_cast<int>(index.size()); }
};

/// None of a problem with points of another dimension, or without what its task needs.
TrueInliers Collect(const Example& example, const LabelOptions& options);

/// Uniform sets, or all where there are no more than `draws`.
std::vector<int> CandidateSets(int count, int size, int draws, const std::string& id);

/// The mean truncated distance, in the solver's unit; infinite once it is known to exceed `bound`.
template <MinimalModel Model>
double MeanDistance(const TrueInliers& inliers, const typename Model::Parameters& model, double bound) {
  constexpr int kBlock = 64;  // between two looks at the bound
  const int count = inliers.count();
  const double* columns[Model::kDimension];
  for (int k = 0; k < Model::kDimension; ++k) columns[k] = inliers.columns.col(k).data();
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

template <MinimalModel Model>
void Offer(const TrueInliers& inliers, const std::array<int, Model::kMinimalSize>& set,
           BestSets<Model::kMinimalSize>* best) {
  typename Model::Parameters models[Model::kMaxSolutions];
  const int solutions = Model::SolveMinimal(inliers.points, set.data(), models);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < solutions; ++i)
    if (models[i].allFinite())
      least = std::min(least, MeanDistance<Model>(inliers, models[i], std::min(least, best->bound())));
  if (least < std::numeric_limits<double>::infinity()) best->Offer(least, set);
}

}  // namespace random_labels_internal

/// OptimalMinimalSets of a model whose sets are too many to look at all: the best of options.draws uniform ones among
/// the true inliers, or of all where there are no more.
///
/// Distance: the mean over all true inliers x of min(d(x), T), in the data's unit, with T = truncation_factor ε and d
/// the candidate's residual (of E times the mean focal length); the least over the solutions of a set. Truncated, so
/// that an inlier that is marked in error cannot decide. Cost: `draws` minimal solves, each with its solutions'
/// distances to the true inliers, which stop as soon as a set cannot be among the best `count`.
template <MinimalModel Model>
std::vector<RankedSet> BestRandomSets(const Example& example, const LabelOptions& options, int count) {
  using namespace random_labels_internal;
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
    set.distance = entry.cost * inliers.unit;
    ranked.push_back(std::move(set));
  }
  return ranked;
}

}  // namespace diffsac
