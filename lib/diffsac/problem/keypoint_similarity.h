#pragma once

#include <Eigen/Core>

namespace diffsac {

/// A row of Problem::scale_rotation_changes: how the keypoint of image 2 differs from that of image 1. Of both: the
/// logarithm of the size (in any unit, the same in both images) and the angle in radians, from the x axis towards the y
/// axis.
Eigen::RowVector2d SimilarityOf(const Eigen::RowVector2d& first, const Eigen::RowVector2d& second);

}  // namespace diffsac
