#pragma once

#include "diffsac/problem/problem.h"

namespace diffsac {

// The share of all places, of an image or of the box of some points, that is within a threshold of one model: how
// likely a point that has nothing to do with the model is to agree with it (ransac/scores/number_of_false_alarms.h).
// All are 1 where the places have no extent.

/// Width and height of what holds these image points (N × 2): the image where its size is known, else their box.
Eigen::Vector2d ImageExtent(const ImageSize& size, const PointMatrix& image_points);

/// Of the bands about epipolar lines, for a threshold of Sampson distances; the longest line counts.
double EpipolarBandShare(const Eigen::Vector2d& extent, double threshold);

/// Of a disc.
double DiscShare(const Eigen::Vector2d& extent, double threshold);

/// Of the slab about the largest line or plane in a cube (a square) as large as uniform points of the same greatest
/// spread fill (SpreadOf): points that all lie on one plane leave a box no volume.
double SlabShare(const PointMatrix& points, double threshold);

/// Of a ball about a point of a cloud (N × 3), in the volume that the cloud occupies: how likely two of its points
/// share a cell of the ball's volume. Points on surfaces leave most of their box empty.
double OccupiedShare(const PointMatrix& cloud, double threshold);

}  // namespace diffsac
