#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/eval/metrics.h"
#include "lab/options/options.h"
#include "lab/train/train_options.h"

namespace diffsac {

/// The training data with what `validation.data` changes, or that alone where it is other data altogether.
Config ValidationData(const TrainConfig& options);

/// mAA of the whole estimator on fixed validation problems, for each outlier ratio or for all of them. The error is
/// that of the task's tables (lab/eval/metrics.h): degrees, of homographies pixels.
class Validation {
 public:
  /// Throws Error for data of another task or without examples.
  explicit Validation(const TrainConfig& options);
  /// What is told after each few problems: how many of all are done. False: no more of them.
  using Watch = std::function<bool(std::int64_t done)>;
  /// Nothing where `watch` said so.
  std::optional<std::vector<double>> Run(const RobustEstimator& method, const Watch& watch) const;
  /// How many problems Run estimates.
  std::int64_t size() const;
  /// A heading for each value of Run: "mAA@10deg", "mAA@0.5deg_outliers_0.7".
  const std::vector<std::string>& names() const { return names_; }

 private:
  void AddGroup(Task task, const Config& data, const std::string& suffix);

  int problems_;
  std::uint64_t seed_;
  Tolerance tolerance_;
  std::vector<std::vector<Example>> examples_;
  std::vector<std::string> names_;
};

}  // namespace diffsac
