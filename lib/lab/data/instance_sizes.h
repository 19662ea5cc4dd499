#pragma once

#include <vector>

#include "diffsac/core/random.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// How many models are true at once in a generated problem, and how unequal their numbers of points are.
struct InstanceOptions {
  Range instances = {1, 6};
  Range size_ratio = {1.0, 3.0};
  void Bind(OptionsBinder& b);
};

/// The fewest points that a generated structure of `task` has, γ + 2: one more than fixes a model and tells it from an
/// accident, so that one can be missed.
int FewestOfInstance(Task task);

/// Throws Error unless every problem of at least `fewest_points` can hold all its structures.
void CheckInstances(const InstanceOptions& options, Task task, double fewest_points);

/// K numbers of points, largest first, that sum to `inliers` and are at least `fewest` each; K · fewest ≤ inliers.
std::vector<int> DrawInstanceSizes(const InstanceOptions& options, int count, int inliers, int fewest, Rng rng);

/// Brings `truth.assignment` and `truth.structures` (structure k of the labels at place k − 1) into the order of the
/// number of points, largest first, equal ones as they stood. Structures of fewer than `fewest` points go; their points
/// become outliers. Inliers and model follow: those of any structure, and that of most points (empty where none is
/// left).
void ArrangeInstances(int fewest, GroundTruth* truth);

}  // namespace diffsac
