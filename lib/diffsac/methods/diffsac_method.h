#pragma once

#include <memory>
#include <vector>

#include "diffsac/diffusion/reverse_sampler.h"
#include "diffsac/methods/diffsac_network.h"
#include "diffsac/methods/diffsac_options.h"
#include "diffsac/methods/method.h"
#include "diffsac/methods/solver_space.h"

namespace diffsac {

/// Confidences over the reverse steps, for pictures: entry s holds κ × N values of ĉ_0 after network call s.
struct ConfidenceSteps {
  std::vector<double> timesteps;
  std::vector<std::vector<float>> confidences;
  int copies = 0;
};

/// The paper's estimator: κ denoised confidence vectors → top-γ minimal sets → sample consensus → refit.
class DiffsacMethod : public Method {
 public:
  /// threads: for features and consensus of a batch; the network uses LibTorch's own.
  DiffsacMethod(std::shared_ptr<const DiffsacNetwork> network, DiffsacOptions options, int threads);
  diffsac::Estimate Estimate(const Problem& problem, std::uint64_t seed) const override;
  std::vector<diffsac::Estimate> EstimateBatch(std::span<const Problem> problems,
                                               std::span<const std::uint64_t> seeds) const override;
  int PreferredBatch() const override { return options_.batch; }
  std::optional<TrainingFacts> Training() const override { return network_->facts; }

  /// Runs the reverse process on one problem and keeps every step. Throws Error for points that cannot be estimated.
  ConfidenceSteps Trace(const Problem& problem, std::uint64_t seed) const;

  /// The κ minimal sets that Estimate solves, γ ascending indices each, without those of another source: for reports of
  /// what the network proposes. Empty for points that cannot be estimated from.
  std::vector<int> MinimalSets(const Problem& problem, std::uint64_t seed) const;

  /// What the network said of one problem; consensus is a function of this alone, bit for bit.
  struct Prediction {
    FeatureSet features;
    std::vector<float> confidences;         ///< rows × N; the final ĉ_0 of the κ copies first, then earlier steps'
    std::vector<float> inlier_probability;  ///< N, empty without the inlier head
  };
  diffsac::Estimate EstimateFrom(const Problem& problem, const Prediction& prediction, std::uint64_t seed) const;

 private:
  std::vector<Prediction> Predict(std::span<const Problem* const> problems, std::span<const std::uint64_t> seeds,
                                  double* ms_features, double* ms_denoise, ConfidenceSteps* steps) const;
  int SetSize() const;
  /// The κ minimal sets, by the options' guide and selection.
  std::vector<int> GuidedSets(const Prediction& prediction, int points, int set_size, const Rng& rng) const;
  /// `count` sets from as many rows of keys in [-1, 1], by the options' selection and temperatures.
  std::vector<int> SetsFrom(std::vector<float> keys, int count, int points, int set_size, Rng rng) const;
  std::vector<int> HeadSets(const Prediction& prediction, int count, int set_size, Rng rng) const;
  void AddExtraSets(const Problem& problem, const SolverSpace& space, int set_size, const Rng& rng,
                    std::vector<int>* sets) const;
  template <MinimalModel Model>
  ConsensusResult Consensus(const Problem& problem, const Prediction& prediction, const Rng& rng) const;

  std::shared_ptr<const DiffsacNetwork> network_;
  DiffsacOptions options_;
  int threads_;
  PointFeatures features_;
  std::unique_ptr<ReverseSampler> sampler_;
};

}  // namespace diffsac
