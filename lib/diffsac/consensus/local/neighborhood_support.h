#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/points.h"

namespace diffsac {

/// How much likelier the neighbours of each match make it that it is right: log P(c | right) / P(c | wrong), N values.
/// c of the `neighbors` nearest matches of the first image are among as many nearest of the second image. Of a right
/// match that is half of them; a wrong one has random neighbours there, of which neighbors / (N − 1) are. (Right
/// matches move with those around them: Bian et al., "GMS: grid-based motion statistics", CVPR 2017; Ma et al.,
/// "Locality preserving matching", IJCV 2019.) matches: N × 4, x1 y1 x2 y2, finite, any unit. 0 for fewer than 2 ·
/// neighbors.
Eigen::VectorXd NeighborhoodSupport(const PointMatrix& matches, int neighbors);

}  // namespace diffsac
