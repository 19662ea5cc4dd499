#pragma once

#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/options.h"
#include "diffsac/core/random.h"
#include "diffsac/data/problem.h"

namespace diffsac {

/// χ: what the network sees of one problem.
struct FeatureSet {
  /// N × width, row-major.
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;
  /// Models solved and scored to make the features; they count in every budget.
  int hypotheses = 0;
  /// The kept hypotheses, best first (M of them, empty for `coordinates`), and their MSAC scores in [0, N].
  std::vector<ModelParameters> models;
  std::vector<double> scores;
};

struct PointFeaturesOptions {
  /// Any of "coordinates", "preference"; their columns stand side by side in this order.
  std::vector<std::string> kinds = {"preference"};
  /// Preference: how many minimal sets are drawn, and how many of the best-scored are kept as columns (M).
  int preference_draws = 100;
  int preference_kept = 16;
  void Bind(OptionsBinder& b);
};

/// Computes point features. Stateless and thread-safe.
class PointFeatures {
 public:
  PointFeatures(PointFeaturesOptions options, Task task);
  /// D, the number of columns.
  int width() const;
  /// `problem` must have at least γ finite points (callers check; see CheckProblem). rng decides the drawn hypotheses.
  FeatureSet Compute(const Problem& problem, Rng rng) const;

 private:
  PointFeaturesOptions options_;
  Task task_;
};

}  // namespace diffsac
