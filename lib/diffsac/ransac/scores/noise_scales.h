#pragma once

#include <Eigen/Core>
#include <optional>

#include "diffsac/ransac/consensus_options.h"
#include "diffsac/ransac/model_hooks.h"
#include "diffsac/ransac/scores/mixture.h"
#include "diffsac/ransac/scores/scorer.h"

namespace diffsac {

/// Lengths beyond these have squares that are no ordinary numbers.
constexpr double kLeastScale = 1e-150;
constexpr double kLargestScale = 1e150;

/// The smallest scale where none is given, as a share of the greatest.
inline constexpr double kLeastScaleShare = 1.0 / 8.0;

/// Between which thresholds one that suits the noise is looked for; linear, in the unit of the residuals.
struct ThresholdRange {
  double least = 0.0;
  double greatest = 0.0;
  double extent = 0.0;  ///< The length over which an outlier's residual is spread: Mixture::Extent.
};

/// An inlier is within so many σ of the noise: 98.8 % of Gaussian residuals.
inline constexpr double kSigmasOfInlier = 2.5;

/// Finds the threshold that suits a model's residuals, when neither the noise nor the share of inliers is known: for
/// the mixture of Gaussian inliers and uniform outliers (mixture.h), the σ for which they are likeliest, each with the
/// share of inliers that suits it best; the threshold is kSigmasOfInlier·σ.
///
/// Thresholds are tried from the greatest down to the least in steps of half an octave, and a parabola says what is
/// between the best and its neighbours. Residuals are counted by their size first, four counts an octave, so that the
/// cost is one pass over the points and a fixed one for the counts. As many of the smallest residuals as a minimal set
/// has points are left out: the model takes them, whatever the noise.
class NoiseEstimator {
 public:
  /// free: γ. Where range.least is not below range.greatest, that is the answer.
  NoiseEstimator(const ThresholdRange& range, int free);
  /// The greatest threshold where no residual is left within it.
  double Threshold(const double* residuals, int count) const;

 private:
  /// Squares of residuals that share exponent and first mantissa bit are counted together; so many octaves of squares.
  static constexpr int kOctaves = 16;
  static constexpr int kBins = 2 * kOctaves;
  static constexpr int kMaxThresholds = 13;
  using Counts = Eigen::Array<double, kBins, 1>;

  Counts Count(const double* residuals, int count) const;
  double LogLikelihood(const Counts& counts, double total, int step) const;

  ThresholdRange range_;
  int free_;
  int steps_;
  Counts ratios_[kMaxThresholds];  ///< Of the density of inliers to that of outliers, by size, for each threshold.
};

/// The lengths that scores and refits of one problem work with, linear, in the unit of its points.
struct NoiseScales {
  double threshold = 0.0;           ///< ε: what an inlier is, or is at most.
  double score_threshold = 0.0;     ///< What scores and local optimisation take for it.
  double refit_threshold = 0.0;     ///< What refits take for it.
  double reweight_threshold = 0.0;  ///< What reweighted refits take for it.
  int residual_dof = 1;             ///< Degrees of freedom of a residual, for MAGSAC++.
  Mixture mixture;                  ///< Of the Gaussian-uniform score and refit.
  double least = 0.0;               ///< From this to `greatest` go what scores and refines over scales.
  double greatest = 0.0;
  std::optional<NoiseEstimator> noise;  ///< Where the threshold of each model is estimated.

  /// A score with these constants.
  Score MakeScore(ScoreKind kind, double inlier_prior) const {
    return Score(kind, {score_threshold, mixture.sigma, mixture.Odds(inlier_prior), residual_dof, least, greatest});
  }

  /// What supports a model of such residuals: what is within ε, or, whatever ε is, within the threshold that suits
  /// them.
  double SupportThreshold(const Eigen::VectorXd& residuals) const {
    return noise ? noise->Threshold(residuals.data(), static_cast<int>(residuals.size())) : threshold;
  }
  /// `given`, or where the noise is estimated, the threshold that suits the model.
  template <MinimalModel Model>
  double ThresholdFor(const Scorer<Model>& scorer, const typename Model::Parameters& model, double given) const {
    return noise ? SupportThreshold(scorer.Residuals(model)) : given;
  }

  /// Whether all are within [kLeastScale, kLargestScale].
  bool Usable() const {
    const auto usable = [](double length) { return length >= kLeastScale && length <= kLargestScale; };
    return usable(threshold) && usable(score_threshold) && usable(refit_threshold) && usable(reweight_threshold) &&
           usable(mixture.sigma) && usable(greatest) && usable(mixture.Extent());
  }
};

/// unit: of how many of the data's units one unit of the points is.
template <MinimalModel Model>
NoiseScales ScalesOf(const PointMatrix& points, double threshold, const ConsensusOptions& options, double unit = 1.0) {
  NoiseScales scales;
  scales.threshold = threshold;
  scales.score_threshold = options.score_threshold_factor * threshold;
  scales.refit_threshold = options.refit_threshold_factor * threshold;
  scales.reweight_threshold = options.score_threshold_factor * scales.refit_threshold;
  scales.residual_dof = options.residual_dof > 0 ? options.residual_dof : ResidualDof<Model>();
  scales.mixture = MakeMixture(points, threshold, options.sigma_factor * threshold);
  scales.greatest = options.greatest_scale > 0.0 ? options.greatest_scale / unit : scales.score_threshold;
  scales.least = options.least_scale > 0.0 ? options.least_scale / unit : kLeastScaleShare * scales.greatest;
  if (options.threshold == ThresholdKind::kAdaptive) {
    const double extent = MakeMixture(points, scales.greatest, scales.greatest).Extent();
    scales.noise.emplace(ThresholdRange{scales.least, scales.greatest, extent}, Model::kMinimalSize);
    // Nothing but the mask asks for ε.
    scales.score_threshold = scales.greatest;
    scales.reweight_threshold = options.refit_threshold_factor * scales.greatest;
  }
  return scales;
}

}  // namespace diffsac
