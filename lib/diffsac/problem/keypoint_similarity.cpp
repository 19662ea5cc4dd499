#include "diffsac/problem/keypoint_similarity.h"

#include <cmath>
#include <numbers>

namespace diffsac {

Eigen::RowVector2d SimilarityOf(const Eigen::RowVector2d& first, const Eigen::RowVector2d& second) {
  const double turn = std::remainder(second[1] - first[1], 2.0 * std::numbers::pi);
  return {second[0] - first[0], turn == -std::numbers::pi ? std::numbers::pi : turn};
}

}  // namespace diffsac
