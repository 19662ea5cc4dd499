#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/points.h"

namespace diffsac {

/// The model that is estimated.
enum class Task { kLine, kPlane };

/// "line", "plane".
std::string ToString(Task task);
/// Throws Error for an unknown name.
Task TaskFromString(const std::string& name);
/// γ, the size of a minimal set: 2 for lines, 3 for planes.
int MinimalSetSize(Task task);
/// Values in a point: 2 for lines, 3 for planes.
int PointDimension(Task task);

/// What an estimator may see of one problem. It carries no ground truth: that is the guard against leaks.
struct Problem {
  Task task = Task::kLine;
  PointMatrix points;              ///< N × PointDimension(task), in the data's unit.
  double inlier_threshold = 0.1;   ///< ε, in the data's unit, linear.
};

/// kOk, or why no estimator can work on these points: fewer than γ, a non-finite value, or points that determine no
/// model (all equal; collinear for planes).
Status CheckProblem(const Problem& problem);

/// What only labels, metrics and the oracle may see.
struct GroundTruth {
  ModelParameters model;               ///< Empty when unknown (real scans).
  std::vector<std::uint8_t> inliers;   ///< N values, 1 for a true inlier; empty when unknown.
};

/// One item of a dataset.
struct Example {
  std::uint64_t index = 0;    ///< Position in the dataset; seeds everything drawn for this problem.
  std::string id;             ///< Unique in the dataset, stable.
  std::string scene;          ///< Group for per-scene means ("all" for synthetic data).
  Problem problem;
  GroundTruth truth;
};

/// A finite or endless (size() < 0) random-access source of examples. `Get` is thread-safe and depends on index alone.
class Dataset {
 public:
  virtual ~Dataset() = default;
  virtual Task task() const = 0;
  virtual std::int64_t size() const = 0;
  virtual Example Get(std::uint64_t index) const = 0;
};

}  // namespace diffsac
