#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/ground_truth/estimate_error.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// What an estimate says of several structures.
struct EstimatedInstances {
  std::vector<ModelParameters> models;
  std::vector<std::int32_t> assignment;  ///< N values: 0 for a point of none, k ≥ 1 for one of models[k − 1].
};

/// Those of an estimate; one, with its inliers, of a row that looks for one model alone, none of a failure.
EstimatedInstances InstancesOf(const Estimate& estimate, const Problem& problem);

/// The assignment problem: for each row a column of its own, or −1, so that the sum of the gains is the largest. Every
/// row has a column where there are as many columns as rows; gains are finite. (The Hungarian method: Kuhn, Naval
/// Research Logistics Quarterly 1955, in the form of shortest augmenting paths, O(rows² columns).)
std::vector<int> BestAssignment(const Eigen::MatrixXd& gains);

/// Per cent of the points whose label is wrong, under the one-to-one matching of found to true structures that leaves
/// the fewest: docs/metrics.md#several-structures. Both hold N labels ≥ 0; NaN for no points.
double Misclassification(std::span<const std::int32_t> found, std::span<const std::int32_t> truth);

/// A found model stands for a true structure when the root mean square of min(r, kRecallTruncation · ε) over the
/// structure's points is at most ε.
inline constexpr double kRecallTruncation = 3.0;

/// Share of the true structures that have points and are found, each by a model of its own; NaN where none has points.
double InstanceRecall(const std::vector<ModelParameters>& found, const Example& example);

/// Degrees between each true structure and the one found that is matched to it, in the order of the truth: of the first
/// as many found models as there are true ones the assignment of least sum; kWorstAngleDeg without a partner (Kluger et
/// al., CVPR 2020, vanishing points). Empty for tasks whose models have no angle.
std::vector<double> InstanceAngles(const std::vector<ModelParameters>& found, const Example& example);

/// Sets error->misclassified, ->recall and ->structure_angles_deg where the truth has structures.
void AddInstancesError(const Estimate& estimate, const Example& example, EstimateError* error);

/// What minimal sets hold of the true structures; NaN without sets or structures.
struct InstanceShares {
  double one_instance = std::numeric_limits<double>::quiet_NaN();  ///< Of the sets, those of one structure alone.
  double instances = std::numeric_limits<double>::quiet_NaN();     ///< Of the structures, those with such a set.
};
InstanceShares InstanceSharesOf(const std::vector<std::vector<int>>& sets, const GroundTruth& truth);

}  // namespace diffsac
