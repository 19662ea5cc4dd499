#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "diffsac/estimate/diffsac_model.h"
#include "diffsac/estimate/diffsac_options.h"
#include "diffsac/estimate/learned_estimator.h"

namespace diffsac {

/// Confidences over the reverse steps, for pictures: entry s holds κ × N values of ĉ_0 after network call s.
struct ConfidenceSteps {
  std::vector<double> timesteps;
  std::vector<std::vector<float>> confidences;
  int num_diffusion_samples = 0;
};

/// The paper's estimator: κ denoised confidence vectors → top-γ minimal sets → sample consensus → refit.
///
/// A prediction's confidences are the final ĉ_0 of the κ copies and then, where the options use them, those of earlier
/// steps, latest first; its weights are the inlier head's probabilities.
class DiffsacEstimator : public LearnedEstimator {
 public:
  /// threads: of a batch (LibTorch, where it computes the network, uses its own). Throws Error for options that the
  /// network cannot serve.
  DiffsacEstimator(std::shared_ptr<const DiffsacModel> network, const DiffsacOptions& options, int threads);
  bool GivesProbabilities() const override { return true; }

  /// Runs the reverse process on one problem and keeps every step; nothing for points that cannot be estimated from,
  /// or where sets are drawn without it.
  std::optional<ConfidenceSteps> Trace(const Problem& problem, std::uint64_t seed) const;

 protected:
  void Infer(std::span<const NormalizedProblem> spaces, std::span<const std::uint64_t> seeds,
             std::span<Prediction> predictions) const override;
  std::unique_ptr<MinimalSampler> MakeSampler(const Guidance& guide) const override;

 private:
  DiffsacEstimator(std::shared_ptr<const DiffsacModel> network, const std::shared_ptr<const DiffsacOptions>& options,
                   int threads);
  std::unique_ptr<MinimalSampler> Copies(const Guidance& guide) const;
  std::unique_ptr<MinimalSampler> Head(const Guidance& guide, const char* stream) const;
  std::unique_ptr<MinimalSampler> Extra(const Guidance& guide) const;

  std::shared_ptr<const DiffsacModel> network_;
  const DiffsacOptions& options_;  ///< What LearnedEstimator holds.
};

}  // namespace diffsac
