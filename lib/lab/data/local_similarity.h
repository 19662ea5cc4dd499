#pragma once

#include <Eigen/Core>
#include <vector>

#include "lab/data/virtual_views.h"

namespace diffsac {

/// A row of Problem::similarities: the similarity nearest to how the surroundings of an exact correspondence go from
/// image 1 to image 2. On the first of `planes` (x2 ~ H x1, pixels) that it obeys it is that of the plane, else that of
/// a small patch which faces both cameras alike, or of infinity where its depth cannot be
/// told: the cameras have one centre, or it lies at an epipole.
Eigen::RowVector2d LocalSimilarity(const VirtualPair& pair, const std::vector<Eigen::Matrix3d>& planes,
                                   const Eigen::Vector4d& match);

}  // namespace diffsac
