#include "lab/ground_truth/random_labels.h"

#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac::random_labels_internal {

TrueInliers Collect(const Example& example, const LabelOptions& options) {
  const Problem& problem = example.problem;
  const auto& marks = example.truth.inliers;
  TrueInliers inliers;
  if (!HasItsNeeds(problem) || problem.points.cols() != PointDimension(problem.task)) return inliers;
  for (int i = 0; i < static_cast<int>(std::min<std::size_t>(marks.size(), problem.points.rows())); ++i)
    if (marks[i] && problem.points.row(i).allFinite()) inliers.index.push_back(i);
  const NormalizedProblem space(problem);
  inliers.points = space.points()(inliers.index, Eigen::all);
  inliers.columns = inliers.points;
  inliers.unit = space.unit();
  inliers.truncation = options.truncation_factor * problem.inlier_threshold / inliers.unit;
  return inliers;
}

std::vector<int> CandidateSets(int count, int size, int draws, const std::string& id) {
  return DrawAllOrSome(count, size, draws, Rng(0).Fork("label_sets/" + id));
}

}  // namespace diffsac::random_labels_internal
