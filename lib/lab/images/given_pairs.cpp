#include "lab/images/given_pairs.h"

#include <algorithm>

#include "diffsac/problem/keypoint_similarity.h"

namespace diffsac {

PointMatrix ScaleRotationChangesOf(const PointMatrix& first, const PointMatrix& second, const MatchIndices& matches) {
  if (first.rows() == 0 || second.rows() == 0) return {};
  PointMatrix scale_rotation_changes(matches.rows(), 2);
  for (Eigen::Index i = 0; i < matches.rows(); ++i)
    scale_rotation_changes.row(i) = SimilarityOf(first.row(matches(i, 0)), second.row(matches(i, 1)));
  return scale_rotation_changes;
}

void KeepAllScaleRotationChangesOrNone(CorrespondenceSet* set) {
  const bool all = std::all_of(set->pairs.begin(), set->pairs.end(), [](const Example& pair) {
    return pair.problem.scale_rotation_changes.rows() == pair.problem.points.rows();
  });
  if (all) return;
  for (Example& pair : set->pairs) pair.problem.scale_rotation_changes.resize(0, 0);
}

}  // namespace diffsac
