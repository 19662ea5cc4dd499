#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diffsac/consensus/hypothesis_source.h"
#include "diffsac/consensus/score.h"
#include "diffsac/core/options.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/hyperplane.h"

namespace diffsac {

struct ConsensusOptions {
  /// "inlier_count" | "msac" | "gaussian_uniform": chooses among hypotheses.
  std::string score = "inlier_count";
  /// Scoring threshold as a multiple of the problem's inlier threshold ε (field-notes: MSAC scores best at 1.5 ε).
  double score_threshold_factor = 1.0;
  /// σ of inlier noise as a multiple of ε, for gaussian_uniform score and refit.
  double sigma_factor = 1.0 / 3.0;
  /// Share of inliers assumed by the gaussian_uniform score inside the loop; refits and the final score estimate it.
  double inlier_prior = 0.3;
  /// Local optimisation of each new best hypothesis inside the loop: "none" | "lo_ransac" (inner sampling from its
  /// inliers and iterated least squares; Chum, Matas, Kittler, DAGM 2003); `local_samples` inner samples each time.
  std::string local_optimization = "none";
  int local_samples = 10;
  /// After the loop: "none" | "inliers" (least squares on the inliers, the paper's) | "iterated" (that, refit_rounds
  /// times, kept while the score does not fall) | "em" (Gaussian-uniform expectation maximisation with σ fixed and the
  /// outlier ratio estimated; each iteration is a soft-weighted least squares, see mixture.h).
  /// Take "iterated" with a smooth final_score: by inlier count the raw hypothesis, chosen for its count, mostly stays.
  /// A refit that fails, or that keeps fewer than γ inliers, leaves the hypothesis as it was.
  std::string refit = "inliers";
  int refit_rounds = 1;
  double refit_threshold_factor = 1.0;
  /// "em" only: the chosen model is refitted once more with σ estimated, where the assumed σ counts as this many
  /// inliers' worth of evidence (see MixtureRefit). 0: σ stays as assumed.
  double sigma_prior = 0.0;
  /// How many of the best distinct hypotheses (other inliers at the scoring threshold) are refitted; the best result by
  /// `final_score` wins, the one that scored higher before the refit when they tie. As `final_score`, gaussian_uniform
  /// is the log-likelihood ratio of the mixture with the share of inliers estimated (MixtureScore in mixture.h).
  int refit_candidates = 1;
  std::string final_score = "inlier_count";
  void Bind(OptionsBinder& b);
};

struct ConsensusResult {
  Status status = Status::kNoModel;
  ModelParameters model;
  std::vector<std::uint8_t> inliers;  ///< residual ≤ threshold under the returned model, exactly
  double score = 0.0;                 ///< of the returned model, by the score that chose it last
  int hypotheses = 0;                 ///< models solved or fitted, all stages: each set, each least squares
  int unique_minimal_sets = 0;
};

/// Optional extra knowledge for the final stage.
struct ConsensusHints {
  /// Models to score along with the solved ones (already paid for by the caller, so not counted as hypotheses again).
  std::vector<ModelParameters> models;
  /// Weights for one weighted least-squares hypothesis (N values ≥ 0; empty: none); counts as one hypothesis.
  Eigen::VectorXd fit_weights;
};

/// The loop: minimal sets → solve → score → (local optimisation) → refit. Sets are given, drawn before anything is
/// scored, and the best is the highest score with the lowest index, so the result does not depend on threads or blocks.
/// Never throws for bad data: fewer than γ points, non-finite values and degenerate data give a status; kNoModel means
/// that every set was degenerate, that there were none, or that ε is not a positive number. A model supported by its
/// own minimal set alone is still kOk. Sets with an index out of range are skipped as degenerate.
/// Throws Error for an option that is none of the documented names.
template <MinimalModel Model>
ConsensusResult SampleConsensus(const PointMatrix& points, double inlier_threshold,
                                const std::vector<int>& minimal_sets, const ConsensusOptions& options, Rng rng,
                                const ConsensusHints& hints = {});

extern template ConsensusResult SampleConsensus<Line>(const PointMatrix&, double, const std::vector<int>&,
                                                      const ConsensusOptions&, Rng, const ConsensusHints&);
extern template ConsensusResult SampleConsensus<Plane>(const PointMatrix&, double, const std::vector<int>&,
                                                       const ConsensusOptions&, Rng, const ConsensusHints&);

/// kOk, or why the points cannot be estimated from (too few, non-finite, all equal / of too low rank).
template <MinimalModel Model>
Status CheckPoints(const PointMatrix& points);

extern template Status CheckPoints<Line>(const PointMatrix&);
extern template Status CheckPoints<Plane>(const PointMatrix&);

/// residual ≤ threshold for each point.
template <MinimalModel Model>
std::vector<std::uint8_t> InlierMask(const PointMatrix& points, const typename Model::Parameters& model,
                                     double threshold) {
  std::vector<std::uint8_t> mask(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    mask[i] = Model::Residual(model, points.data() + i * points.cols()) <= threshold;
  return mask;
}

}  // namespace diffsac
