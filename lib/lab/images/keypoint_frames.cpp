#include "lab/images/keypoint_frames.h"

#include <algorithm>

#include "diffsac/problem/keypoint_similarity.h"

namespace diffsac {

PointMatrix SimilaritiesOf(const PointMatrix& first, const PointMatrix& second, const MatchIndices& matches) {
  if (first.rows() == 0 || second.rows() == 0) return {};
  PointMatrix similarities(matches.rows(), 2);
  for (Eigen::Index i = 0; i < matches.rows(); ++i)
    similarities.row(i) = SimilarityOf(first.row(matches(i, 0)), second.row(matches(i, 1)));
  return similarities;
}

void KeepAllSimilaritiesOrNone(CorrespondenceSet* set) {
  const bool all = std::all_of(set->pairs.begin(), set->pairs.end(), [](const Example& pair) {
    return pair.problem.similarities.rows() == pair.problem.points.rows();
  });
  if (all) return;
  for (Example& pair : set->pairs) pair.problem.similarities.resize(0, 0);
}

}  // namespace diffsac
