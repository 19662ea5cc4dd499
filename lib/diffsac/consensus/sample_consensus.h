#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diffsac/consensus/hypothesis_source.h"
#include "diffsac/consensus/score.h"
#include "diffsac/consensus/stopping.h"
#include "diffsac/core/options.h"
#include "diffsac/core/status.h"
#include "diffsac/geometry/hyperplane.h"

namespace diffsac {

struct ConsensusOptions {
  /// "inlier_count" | "msac" | "gaussian_uniform" | "magsac_pp": chooses among hypotheses (score.h).
  std::string score = "inlier_count";
  /// Scoring threshold as a multiple of the problem's inlier threshold ε (field-notes: MSAC scores best at 1.5 ε;
  /// MAGSAC++, which knows no σ, at 2 to 3 ε).
  double score_threshold_factor = 1.0;
  /// Degrees of freedom of a residual for MAGSAC++ (score and weights), 1 to 6; 0: the model's own (model_hooks.h).
  int residual_dof = 0;
  /// σ of inlier noise as a multiple of ε, for gaussian_uniform score and refit.
  double sigma_factor = 1.0 / 3.0;
  /// Share of inliers assumed by the gaussian_uniform score inside the loop; refits and the final score estimate it.
  double inlier_prior = 0.3;
  /// Local optimisation of each new best hypothesis inside the loop; what scores no higher is dropped.
  ///   "none"
  ///   "lo_ransac"  inner sampling from its inliers and iterated least squares (Chum, Matas, Kittler, DAGM 2003);
  ///                `local_samples` inner samples each time
  ///   "irls"       least squares reweighted by MAGSAC++, `irls_rounds` at most (irls.h)
  ///   "gc_ransac"  inliers labelled by a graph cut over the `graph_neighbors` nearest points, with `spatial_weight` λ,
  ///                and `local_samples` fits to samples of them (graph_cut_optimization.h)
  ///   "lm"         the model's own nonlinear refinement, where it has one (model_hooks.h)
  std::string local_optimization = "none";
  int local_samples = 10;
  int irls_rounds = 20;
  int graph_neighbors = 8;
  double spatial_weight = 0.1;
  /// Drops hypotheses by a sequential probability ratio test before they are scored in full (sprt.h). Unlike the bound
  /// that always ends hopeless scoring, this can change the result.
  bool sprt = false;
  /// When to end a search that draws from a source: "budget" (exactly max_iterations draws, unless the source runs out)
  /// | "confidence" (once the best model's inliers, at ε, say that a better one would have been drawn with
  /// probability `confidence`, by the exact hypergeometric rule; after min_iterations at least and max_iterations at
  /// most). A search over given sets takes them all.
  std::string stopping = "budget";
  int max_iterations = 1000;
  int min_iterations = 0;
  double confidence = 0.99;
  /// After the loop: "none" | "inliers" (least squares on the inliers, the paper's) | "iterated" (that, refit_rounds
  /// times, kept while the score does not fall) | "em" (Gaussian-uniform expectation maximisation with σ fixed and the
  /// outlier ratio estimated; each iteration is a soft-weighted least squares, see mixture.h) | "irls" (reweighted by
  /// MAGSAC++, threshold refit_threshold_factor times the score's, kept while the final score does not fall).
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
  /// Of each refitted candidate: "none" | "lm" (the model's own nonlinear refinement, where it has one; kept unless the
  /// final score falls).
  std::string final_refinement = "none";
  /// Sets that are drawn and scored at a time, 0: from 64 growing to 4096. Results do not depend on it.
  int block_size = 0;
  void Bind(OptionsBinder& b);
};

/// Sets kept in ConsensusResult::first_sets: as many as the paper's κ.
constexpr int kReportedSets = 20;

struct ConsensusResult {
  Status status = Status::kNoModel;
  ModelParameters model;
  std::vector<std::uint8_t> inliers;  ///< residual ≤ threshold under the returned model, exactly
  /// Other models explain the inliers as well: for an essential matrix the motion is a rotation alone, t is anything.
  bool ambiguous = false;
  double score = 0.0;                 ///< of the returned model, by the score that chose it last
  int hypotheses = 0;                 ///< models solved or fitted, all stages: each set, each least squares
  int unique_minimal_sets = 0;
  /// The first (up to kReportedSets) minimal sets that were drawn, for reports of what a source proposes.
  std::vector<std::vector<int>> first_sets;
  std::int64_t iterations = 0;            ///< minimal sets drawn
  StopReason stop = StopReason::kNotRun;  ///< why there were no more
  int rejected_early = 0;                 ///< models dropped by the sequential test
};

/// Thresholds beyond these have squares that are no ordinary numbers.
constexpr double kLeastScale = 1e-150;
constexpr double kLargestScale = 1e150;

/// Optional extra hypotheses.
struct ConsensusHints {
  /// Models to score along with the solved ones (already paid for by the caller, so not counted as hypotheses again).
  std::vector<ModelParameters> models;
  /// Weights for one weighted least-squares hypothesis (N values ≥ 0; empty: none); counts as one hypothesis.
  Eigen::VectorXd fit_weights;
};

/// The loop: minimal sets → solve → score → (local optimisation) → refit. Sets are given, drawn before anything is
/// scored, and the best is the highest score with the lowest index, so the result does not depend on threads or blocks.
/// Never throws for bad data: fewer than γ points, non-finite values and degenerate data give a status; kNoModel means
/// that every set was degenerate, that there were none, or that ε or a multiple of it that the options ask for is not
/// within [kLeastScale, kLargestScale]. A model supported by its own minimal set alone is still kOk. Sets with an index
/// out of range are skipped as degenerate. Throws Error for an option that is none of the documented names.
template <MinimalModel Model>
ConsensusResult SampleConsensus(const PointMatrix& points, double inlier_threshold,
                                const std::vector<int>& minimal_sets, const ConsensusOptions& options, Rng rng,
                                const ConsensusHints& hints = {});

/// The same over a source: draws and scores sets, in blocks and by up to `threads` threads (0: all cores), until
/// options.stopping says so. Sets come from rng.Fork("minimal_sets") and the index of the draw alone, and draws are
/// taken in their order, so the result is the same bit for bit for any number of threads and any block size. Hints are
/// considered first, which makes a good one save work; they count as no draws.
template <MinimalModel Model>
ConsensusResult SampleConsensus(const PointMatrix& points, double inlier_threshold, const HypothesisSource& source,
                                const ConsensusOptions& options, Rng rng, const ConsensusHints& hints = {},
                                int threads = 1);

/// kOk, or why the points cannot be estimated from (too few, non-finite, all equal / of too low rank).
template <MinimalModel Model>
Status CheckPoints(const PointMatrix& points);

/// The instantiations for one model: extern in this header, defined in a file that includes sample_consensus_impl.h.
/// A model of one's own needs that include alone.
#define DIFFSAC_CONSENSUS_TEMPLATES(prefix, Model)                                                                  \
  prefix template ConsensusResult SampleConsensus<Model>(const PointMatrix&, double, const std::vector<int>&,       \
                                                         const ConsensusOptions&, Rng, const ConsensusHints&);      \
  prefix template ConsensusResult SampleConsensus<Model>(const PointMatrix&, double, const HypothesisSource&,       \
                                                         const ConsensusOptions&, Rng, const ConsensusHints&, int); \
  prefix template Status CheckPoints<Model>(const PointMatrix&);

DIFFSAC_CONSENSUS_TEMPLATES(extern, Line)
DIFFSAC_CONSENSUS_TEMPLATES(extern, Plane)

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
