#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "diffsac/estimate/robust_estimator.h"
#include "lab/ground_truth/example.h"
#include "lab/options/options.h"

namespace diffsac {

/// What a row is told of a problem beside the example.
struct RowCall {
  const std::string& condition;
  std::uint64_t experiment_seed;
  std::uint64_t seed;  ///< The problem's (ProblemSeed).
};

/// A row of a table. Most look at the problem alone, which is what an estimator is; others are shown the whole example:
/// the oracle its truth, recorded rows its name.
class TableRow {
 public:
  using OfExample = std::function<Estimate(const Example&, const RowCall&)>;
  template <std::derived_from<RobustEstimator> Estimator>
  TableRow(std::unique_ptr<Estimator> estimator) : estimator_(std::move(estimator)) {}
  TableRow(OfExample of_example) : of_example_(std::move(of_example)) {}

  Estimate Run(const Example& example, const RowCall& call) const {
    return estimator_ ? estimator_->Run(example.problem, call.seed) : of_example_(example, call);
  }
  int PreferredBatch() const { return estimator_ ? estimator_->PreferredBatch() : 1; }
  bool GivesProbabilities() const { return estimator_ && estimator_->GivesProbabilities(); }
  std::optional<TrainingFacts> Training() const { return estimator_ ? estimator_->Training() : std::nullopt; }
  /// Null for a row that is shown the example.
  const RobustEstimator* estimator() const { return estimator_.get(); }
  void SetWithoutScores(RobustEstimator::Other other) { estimator_->SetWithoutScores(std::move(other)); }
  std::unique_ptr<RobustEstimator> TakeEstimator() { return std::move(estimator_); }

 private:
  std::unique_ptr<RobustEstimator> estimator_;
  OfExample of_example_;
};

/// What a program says about all its methods.
struct EstimatorContext {
  std::string checkpoint_override;  ///< --checkpoint: replaces that of the rows of its method
  std::string device = "cpu";
  int threads = 0;  ///< 0: all cores
};

/// Builds the row that `type` names. Throws Error: unknown type (with the nearest), bad option, bad checkpoint, a
/// device that is not there.
TableRow MakeRow(const Config& config, Task task, const EstimatorContext& context);

/// The same for problems that are no table's. Throws Error as well for a row that is shown the example.
std::unique_ptr<RobustEstimator> MakeEstimator(const Config& config, Task task, const EstimatorContext& context);

/// The row with every key filled in, `type` first: its defaults for the task, the checkpoint's `inference` group, its
/// own keys. Makes the same method. Throws as MakeEstimator does, but loads no network.
Config ResolvedRow(const Config& config, Task task, const EstimatorContext& context);

}  // namespace diffsac
