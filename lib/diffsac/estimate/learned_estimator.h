#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "diffsac/core/enum_names.h"
#include "diffsac/estimate/learned_model.h"
#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/instances/instances.h"
#include "diffsac/ransac/sample_consensus.h"
#include "diffsac/ransac/samplers/make_minimal_sampler.h"
#include "diffsac/ransac/samplers/minimal_sampler.h"

namespace diffsac {

/// Whose probabilities of being an inlier weigh the points in scores (consensus.inlier_prior_power).
///   kNetwork  "network": the network's, where it says some; else the ratio's
///   kRatio    "ratio": those of the matching ratio (estimate/estimation_priors.h)
///   kBoth     "both": the geometric mean of the two
enum class PriorSource { kNetwork, kRatio, kBoth };
template <>
inline constexpr auto kEnumNames<PriorSource> = NamesOf<PriorSource>({{PriorSource::kNetwork, "network"},
                                                                      {PriorSource::kRatio, "ratio"},
                                                                      {PriorSource::kBoth, "both"}});

/// What all learned rows have: in the group `inference` of a training configuration (kept in the checkpoint), any key
/// of which a row of an experiment may override.
struct LearnedOptions {
  /// By which of the task's models minimal sets are solved; empty: its own. As in training (the key `model` beside
  /// `task`), unless the row has the key `model`; no key of the group `inference`.
  std::string model;
  /// Score the hypotheses that the features were made from as well (they are paid for and counted).
  bool feature_hypotheses = false;
  /// Add one weighted least-squares hypothesis with the network's weights of all points.
  bool weighted_fit = false;
  /// Minimal sets that the residual features are drawn from, all counted in the budget; 0: as in training. More find
  /// a good hypothesis at high outlier ratios; the network still sees the best `residual_kept` of them.
  int residual_draws = 0;
  int batch = 8;           ///< problems a network call
  int search_threads = 1;  ///< Threads of one search, 0: all cores. Set by EstimateOptions, not by a key.
  PriorSource inlier_prior_of = PriorSource::kNetwork;
  ConsensusOptions consensus;
  InstanceSearchOptions instances;
  /// As ClassicalOptions::search_again.
  bool search_again = false;
  /// As ClassicalOptions::photographs.
  bool photographs = false;
};

/// What the network said of one problem; consensus is a function of this alone, bit for bit.
struct Prediction {
  FeatureSet features;
  std::vector<float> confidences;  ///< rows × N, as the method says; empty for methods without
  std::vector<float> weights;  ///< N values ≥ 0, in proportion to how likely an inlier is; empty for networks without
};

/// By point, of a problem's ratios (where it has them) and what a network says.
Eigen::VectorXd InlierPriors(const NormalizedProblem& space, const std::vector<float>& of_network, PriorSource source);

/// The core of every learned row: features → network, for a batch of problems at once → a sampler of minimal sets →
/// sample consensus → refit. A method says what its network makes of a batch, and which sets come of it.
///
/// Example: the whole of a row whose network weighs points, but for its options (weighted_estimator.h):
/// ```
/// void Infer(std::span<const NormalizedProblem>, std::span<const std::uint64_t>, std::span<Prediction> predictions)
/// const {
///   for (Prediction& prediction : predictions) prediction.weights = weights_->Of(prediction.features);
/// }
/// std::unique_ptr<MinimalSampler> MakeSampler(const Guidance& guide) const override {
///   return std::make_unique<WeightedSampler>(Doubles(guide.prediction.weights), guide.set_size,
///                                           guide.rng.Fork("minimal_sets"));
/// }
/// ```
class LearnedEstimator : public RobustEstimator {
 public:
  bool SearchesAgain() const final { return options_->search_again && !instances_.Several(); }
  int PreferredBatch() const final { return network_->batches ? options_->batch : 1; }
  std::optional<TrainingFacts> Training() const final { return network_->facts; }

  /// What the network says of problems that can be estimated from (see CheckSpace).
  std::vector<Prediction> Predict(std::span<const NormalizedProblem> spaces,
                                  std::span<const std::uint64_t> seeds) const;
  Estimate EstimateFrom(const NormalizedProblem& space, const Prediction& prediction, std::uint64_t seed) const;

 protected:
  /// What the sets of one problem may come from.
  struct Guidance {
    const NormalizedProblem& space;  ///< the problem, its points as they are solved
    const Prediction& prediction;
    int set_size;  ///< γ
    Rng rng;       ///< of the estimate
  };

  /// threads: for features and consensus of a batch. Throws Error for options that the network cannot serve.
  LearnedEstimator(std::shared_ptr<const LearnedModel> network, std::shared_ptr<const LearnedOptions> options,
                   int threads);

  /// Fills confidences and weights of a batch's predictions, whose features are known.
  virtual void Infer(std::span<const NormalizedProblem> spaces, std::span<const std::uint64_t> seeds,
                     std::span<Prediction> predictions) const = 0;
  /// The sets, in the order in which they are tried; how many the loop takes is decided by consensus' options. May
  /// borrow what it is given.
  virtual std::unique_ptr<MinimalSampler> MakeSampler(const Guidance& guide) const = 0;

  /// Whether the row's model can be solved from the points.
  Status Check(const NormalizedProblem& space) const {
    return space.points().rows() > network_->most_points ? Status::kTooManyPoints : CheckSpace(space, model_);
  }
  const PointFeatures& features() const { return features_; }
  int threads() const { return threads_; }
  std::vector<FeatureSet> ComputeFeatures(std::span<const NormalizedProblem> spaces,
                                          std::span<const std::uint64_t> seeds) const;

 private:
  struct Timed {
    std::vector<Prediction> predictions;
    double ms_features = 0.0;
    double ms_network = 0.0;
  };
  Estimate DoRun(const NormalizedProblem& space, std::uint64_t seed) const final;
  std::vector<Estimate> DoRunBatch(std::span<const NormalizedProblem> spaces,
                                   std::span<const std::uint64_t> seeds) const final;
  Timed PredictTimed(std::span<const NormalizedProblem> spaces, std::span<const std::uint64_t> seeds) const;
  template <MinimalModel Model>
  Estimate Consensus(const NormalizedProblem& space, const Prediction& prediction, const Rng& rng) const;
  /// ask: what the network says; called when the sets before its own are used up.
  EstimationPriors PriorsOf(const NormalizedProblem& space, const Prediction& prediction) const;
  /// The sets among some of the points, with what the network said of these.
  std::unique_ptr<MinimalSampler> MakeSamplerOfRows(const Guidance& whole, const std::vector<int>& rows) const;

  std::shared_ptr<const LearnedModel> network_;
  std::shared_ptr<const LearnedOptions> options_;  ///< The whole of the derived class's, which refers to it.
  InstanceSearchOptions instances_;                ///< Of the options, with its chooser.
  int threads_;
  TaskModel model_;
  PointFeatures features_;
};

}  // namespace diffsac
