#pragma once

#include <memory>
#include <vector>

#include "diffsac/consensus/sample_consensus.h"
#include "diffsac/core/options.h"
#include "diffsac/methods/learned_weights.h"
#include "diffsac/methods/method.h"

namespace diffsac {

/// How learned weights are used: the group `inference` of a training configuration of `method: ng_ransac` or `clnet`
/// (kept in the checkpoint), any key of which a row of an experiment may override.
struct WeightedMethodOptions {
  /// Minimal sets drawn with the weights, without replacement within a set; all are solved, repeated ones as well.
  int hypotheses = 20;
  /// Add one weighted non-minimal fit with the weights of all points.
  bool weighted_fit = false;
  /// Points in a minimal set of a fundamental matrix, 7 or 8.
  int fundamental_points = 7;
  /// Score the hypotheses that the features were made from as well (they are paid for and counted).
  bool feature_hypotheses = false;
  /// Minimal sets that the preference features are drawn from, all counted in the budget; 0: as in training.
  int preference_draws = 0;
  int batch = 8;  ///< problems a network call
  ConsensusOptions consensus;
  void Bind(OptionsBinder& b);
};

/// Defaults of "ng_ransac" (20 sets) and of "clnet" (no set: one weighted fit, whose inliers among all points the
/// consensus' refit then takes, which is the paper's full-size verification).
WeightedMethodOptions DefaultWeightedOptions(const std::string& method);

/// Learned weights → minimal sets, a weighted fit, or both → sample consensus → refit. The rows `ng_ransac` and
/// `clnet`.
class WeightedMethod : public Method {
 public:
  /// threads: for features and consensus of a batch; the network uses LibTorch's own.
  WeightedMethod(std::shared_ptr<const LearnedWeights> weights, WeightedMethodOptions options, int threads);
  diffsac::Estimate Estimate(const Problem& problem, std::uint64_t seed) const override;
  std::vector<diffsac::Estimate> EstimateBatch(std::span<const Problem> problems,
                                               std::span<const std::uint64_t> seeds) const override;
  int PreferredBatch() const override { return options_.batch; }
  std::optional<TrainingFacts> Training() const override { return weights_->facts; }

  /// What the network said of one problem; consensus is a function of this alone, bit for bit.
  struct Prediction {
    FeatureSet features;
    std::vector<double> weights;  ///< N
  };
  diffsac::Estimate EstimateFrom(const Problem& problem, const Prediction& prediction, std::uint64_t seed) const;
  /// The weights of problems that can be estimated from.
  std::vector<Prediction> Predict(std::span<const Problem* const> problems, std::span<const std::uint64_t> seeds,
                                  double* ms_features, double* ms_network) const;

 private:
  template <MinimalModel Model>
  ConsensusResult Consensus(const Problem& problem, const Prediction& prediction, const Rng& rng) const;

  std::shared_ptr<const LearnedWeights> weights_;
  WeightedMethodOptions options_;
  int threads_;
  PointFeatures features_;
};

}  // namespace diffsac
