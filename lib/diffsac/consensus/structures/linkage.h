#pragma once

#include <Eigen/Core>
#include <vector>

namespace diffsac {

/// How much each point prefers each hypothesis, N × H, in [0, 1]; a point a row.
using PreferenceMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Agglomerative clustering of points by preferences: every point starts alone; the two clusters at the least Tanimoto
/// distance
///
///   d(p, q) = 1 − p·q / (|p|² + |q|² − p·q)
///
/// become one with the preference min(p, q), until no two have a hypothesis in common (d = 1). Of binary preferences it
/// is the Jaccard distance, and the result that of J-linkage (Toldo and Fusiello, ECCV 2008); of soft ones T-linkage
/// (Magri and Fusiello, CVPR 2014). So all points of a cluster are within reach of one hypothesis.
///
/// Returns a cluster's number for each point, 0 … in the order of the clusters' first points. Ties: the cluster with
/// the lowest first points. Time O(N² H), memory O(N H).
std::vector<int> LinkPoints(const PreferenceMatrix& preferences);

}  // namespace diffsac
