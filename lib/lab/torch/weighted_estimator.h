#pragma once

#include <memory>
#include <string>

#include "diffsac/estimate/learned_estimator.h"
#include "lab/options/options.h"
#include "lab/torch/weight_network.h"

namespace diffsac {

/// How learned weights are used: the group `inference` of a training configuration of `method: ng_ransac` or `clnet`
/// (kept in the checkpoint), any key of which a row of an experiment may override.
struct WeightedEstimatorOptions : LearnedOptions {
  int max_iterations = 20;
  void Bind(OptionsBinder& b);
};

/// Defaults of "ng_ransac" (20 sets) and of "clnet" (no set: one weighted fit, whose inliers among all points the
/// consensus' refit then takes, which is the paper's full-size verification).
WeightedEstimatorOptions DefaultWeightedOptions(const std::string& method);

/// Throws Error with its line for a key that the row itself writes and that changes nothing there. options: the row's,
/// those of its checkpoint below them.
void CheckRow(const Config& row, const WeightedEstimatorOptions& options, const LearnedWeights& weights);

/// Learned weights → minimal sets, a weighted fit, or both → sample consensus → refit. The rows `ng_ransac` and
/// `clnet`. A prediction has weights alone.
class WeightedEstimator : public LearnedEstimator {
 public:
  /// threads: for features and consensus of a batch; the network uses LibTorch's own.
  WeightedEstimator(std::shared_ptr<const LearnedWeights> weights, const WeightedEstimatorOptions& options,
                    int threads);

 protected:
  void Infer(std::span<const NormalizedProblem> spaces, std::span<const std::uint64_t> seeds,
             std::span<Prediction> predictions) const override;
  std::unique_ptr<MinimalSampler> MakeSampler(const Guidance& guide) const override;

 private:
  std::shared_ptr<const LearnedWeights> weights_;
  int max_iterations_;
};

}  // namespace diffsac
