#pragma once

#include <Eigen/Core>

#include "diffsac/geometry/points.h"
#include "diffsac/problem/good_neighbors.h"

namespace diffsac {

inline constexpr int kSimilarityColumns = 6;

/// Whether the similarity between the keypoints of a match, s R(θ), agrees with the matches around it and with all good
/// ones, after Hough voting by keypoints (Lowe, "Distinctive image features from scale-invariant keypoints", IJCV 2004)
/// and weak geometric consistency (Jégou et al., "Hamming embedding and weak geometric consistency", ECCV 2008). Two
/// right matches i, j that lie near each other predict each other: Δ2 ≈ s R(θ) Δ1 for the steps Δ1, Δ2 from i to j.
/// With |s R(θ) Δ1 − Δ2| / min(|Δ2| + 0.02, s (|Δ1| + 0.02)) the error of a similarity, e_ij the larger one of those of
/// i and j, at most 100, and A and B the 8 nearest other good matches in image 1 and in image 2 (FindGoodNeighbors),
/// N × 6:
///   0  log(1 + Σ_A,B 1 / (1 + (e_ij / 0.3)²)) − 1: how many neighbours i predicts, and they it
///   1  (2 + log(c + 0.001)) / 3, c the mean of the fourth smallest e_ij of A and that of B
///   2  mean of median_A and median_B |log s_j − log s_i|, at most 2
///   3  the same of |θ_j − θ_i|, between 0 and π
///   4  (2.3 + log(d + 0.01)) / 1.2, d the mean of exp(−(Δ log s)² / 2(0.3)² − Δθ² / 2(0.3)²) over the other good
///      matches, by a histogram of cells of 0.1 and 2π / 64
///   5  1
/// All are 0 where the problem has no similarities, and for fewer than 9 matches. The same when the images are
/// exchanged, mirrored or turned together; but for the cells also when one is turned alone. `coordinates`: N × 4,
/// finite, in units of the focal length or so; `around`: of these. `similarities`: as Problem::scale_rotation_changes,
/// with steps in these coordinates (InCoordinates).
Eigen::Matrix<float, Eigen::Dynamic, kSimilarityColumns> SimilarityFeatures(const PointMatrix& coordinates,
                                                                            const PointMatrix& scale_rotation_changes,
                                                                            const GoodNeighbors& around);

/// Problem::scale_rotation_changes, given in pixels, where steps are measured in `coordinates`, which are `points`
/// moved and scaled in each image.
PointMatrix InCoordinates(const PointMatrix& scale_rotation_changes, const PointMatrix& points,
                          const PointMatrix& coordinates);

}  // namespace diffsac
