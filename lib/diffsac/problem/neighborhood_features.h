#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/points.h"
#include "diffsac/problem/good_neighbors.h"

namespace diffsac {

inline constexpr int kNeighborhoodColumns = 3;

/// What the surroundings of each match say about it, after the local consensus of Zhao et al. ("Progressive
/// correspondence pruning by consensus learning", ICCV 2021) and of Ma et al. ("Locality preserving matching", IJCV
/// 2019): correct matches move as the good matches around them do. With A and B the 8 nearest other good matches in
/// image 1 and in image 2 (FindGoodNeighbors), and Δ1, Δ2 the vectors to them in both images, N × 3:
///   0  |A ∩ B| / 8
///   1  s / 2, s the mean of median_A log(|Δ2| / |Δ1|) and median_B log(|Δ1| / |Δ2|), at most 4
///   2  (2 + log(c + 0.001)) / 3, c the mean of median_A |Δ2 − Δ1| / (|Δ1| + 0.02) and median_B |Δ2 − Δ1| / (|Δ2| +
///   0.02),
///      at most 100
/// The same when the images are exchanged, mirrored or turned together; 0 for fewer than 9 matches.
/// `coordinates`: N × 4, finite, in units of the focal length or so; `around`: of these.
Eigen::Matrix<float, Eigen::Dynamic, kNeighborhoodColumns> NeighborhoodFeatures(const PointMatrix& coordinates,
                                                                                const GoodNeighbors& around);

}  // namespace diffsac
