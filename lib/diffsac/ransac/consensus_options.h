#pragma once

#include "diffsac/ransac/scores/score.h"
#include "diffsac/ransac/stopping_rule.h"

namespace diffsac {

/// Local optimisation of each new best minimal model inside the loop; what scores no higher is dropped.
///   kNone            "none"
///   kInnerSamples    "lo_ransac": inner sampling from its inliers and iterated least squares (Chum, Matas, Kittler,
///                    DAGM 2003); `local_samples` inner samples each time
///   kReweighted      "irls": least squares reweighted by MAGSAC++, `irls_rounds` at most (OptimizeReweighted)
///   kGraphCut        "gc_ransac": inliers labelled by a graph cut over the `graph_neighbors` nearest points, with
///                    `spatial_weight` λ, and `local_samples` fits to samples of them (OptimizeByGraphCut)
///   kRefinement      "lm": the model's own nonlinear refinement, where it has one (model_hooks.h)
enum class LocalOptimization { kNone, kInnerSamples, kReweighted, kGraphCut, kRefinement };

/// After the loop. A refit that fails, that keeps fewer than γ inliers or that makes worse what it should make better
/// leaves the hypothesis as it was. Least squares of an essential matrix is nonlinear, from the hypothesis (FitAgain in
/// model_hooks.h).
///   kNone        "none"
///   kInliers     "inliers": least squares on the inliers, the paper's; kept while MSAC at the refit's own threshold,
///                the squares that it lowers, does not fall
///   kIterated    "iterated": that, refit_rounds times, kept while the final score does not fall. Take it with a smooth
///                final_score: by inlier count the raw hypothesis, chosen for its count, mostly stays.
///   kMixture     "em": Gaussian-uniform expectation maximisation with σ fixed and the outlier ratio estimated; each
///                iteration is a soft-weighted least squares (mixture.h); kept while the likelihood does not fall
///   kReweighted  "irls": reweighted by MAGSAC++, threshold refit_threshold_factor times the score's, kept while the
///                final score does not fall
enum class Refit { kNone, kInliers, kIterated, kMixture, kReweighted };

/// The model's own nonlinear refinement, where it has one; kept unless the final score falls.
///   kNone        "none"
///   kRefinement  "lm": with the loss truncated at the threshold
///   kMarginalised      "lm_marginalised": with the loss over all scales up to ε (geometry/robust_loss.h)
enum class FinalRefinement { kNone, kRefinement, kMarginalised };

/// What an inlier is: for the mask, the stopping rule, local optimisation and refits.
///   kFixed      "fixed": a residual of at most ε
///   kAdaptive   "adaptive": of at most the threshold that suits the model's own residuals, between least_scale and
///               greatest_scale (noise_scales.h); in the mask, at most ε as well
enum class ThresholdKind { kFixed, kAdaptive };

struct ConsensusOptions : StoppingOptions {
  /// Chooses among hypotheses (score.h).
  ScoreKind score = ScoreKind::kInlierCount;
  /// Scoring threshold as a multiple of the problem's inlier threshold ε (MSAC scores best at 1.5 ε; MAGSAC++, which
  /// knows no σ, at 2 to 3 ε).
  double score_threshold_factor = 1.0;
  /// Degrees of freedom of a residual for MAGSAC++ (score and weights), 1 to 6; 0: the model's own (model_hooks.h).
  int residual_dof = 0;
  ThresholdKind threshold = ThresholdKind::kFixed;
  /// The smallest and the greatest threshold that a score (sigma_marginalised_msac) or refinement over scales, or an
  /// estimated noise, reckons with; in the data's unit. 0: an eighth of the greatest, and the scoring threshold. With
  /// both given, and the noise estimated, ε is what the mask's threshold is at most, and nothing else.
  double least_scale = 0.0;
  double greatest_scale = 0.0;
  /// Each point counts in scores and nonlinear refinement with the probability of being an inlier that is known of it
  /// before (EstimationPriors::inlier_priors), to this power. 0: alike.
  double inlier_prior_power = 0.0;
  /// Epipolar models, where it is known how keypoints turned (EstimationPriors::turns): a match whose keypoint does not
  /// turn as its epipolar lines do (TurnsAsLines in geometry/epipolar.h) counts with this in scores and nonlinear
  /// refinement. 1: alike.
  double keypoint_orientation_weight = 1.0;
  /// Fundamental matrices and homographies: scores are divided by 1 + this · (s₁ − s₂)/s₂ of the essential matrix, or
  /// (s₁ − s₃)/s₂ of the plane's motion, that a model makes with guessed cameras, where the images' sizes are known
  /// (EstimationPriors::cameras). Unknown focal lengths: by 1 + this · the square of how many standard deviations of
  /// the prior log f is off.
  double camera_prior = 0.0;
  /// Where a focal length is estimated: the standard deviation of its logarithm before anything is seen, of images for
  /// which none is given (CameraPriorHint::focal).
  double focal_log_sigma = 0.43;
  /// σ of inlier noise as a multiple of ε, for mlesac score and refit.
  double sigma_factor = 1.0 / 3.0;
  /// Share of inliers assumed by the mlesac score inside the loop; refits and the final score estimate it.
  double inlier_prior = 0.3;
  LocalOptimization local_optimization = LocalOptimization::kNone;
  int local_samples = 10;
  int irls_rounds = 20;
  int graph_neighbors = 8;
  double spatial_weight = 0.1;
  Refit refit = Refit::kInliers;
  int refit_rounds = 1;
  double refit_threshold_factor = 1.0;
  /// kMixture only: the chosen model is refitted once more with σ estimated, where the assumed σ counts as this many
  /// inliers' worth of evidence (see MixtureRefit). 0: σ stays as assumed.
  double sigma_prior = 0.0;
  /// How many of the best distinct hypotheses (other inliers at the scoring threshold) are refitted; the best result by
  /// `final_score` wins, the one that scored higher before the refit when they tie. As `final_score`, mlesac
  /// is the log-likelihood ratio of the mixture with the share of inliers estimated (MixtureScore in mixture.h).
  int refit_candidates = 1;
  /// Where the search did not end confident: so many of the best draws that differ (of their inliers less than 0.9 are
  /// common) are each optimised locally as well, and hypotheses count as distinct by the same measure. 0: none, and
  /// those are distinct that differ in one inlier.
  int lo_starts = 0;
  /// There as well: the chosen model is optimised locally and refined so many times more, each time from other random
  /// samples of its inliers; kept where the final score rises.
  int lo_restarts = 0;
  ScoreKind final_score = ScoreKind::kInlierCount;
  /// All candidates are refitted once and refined by a few steps, and so many, those of the highest final score, to the
  /// end. 0: all of them.
  int num_finalists = 0;
  /// Of each refitted candidate.
  FinalRefinement final_refinement = FinalRefinement::kNone;
  /// Sets that are drawn and scored at a time, 0: from 64 growing to 4096. Results do not depend on it.
  int block_size = 0;
  /// Whether it is one of the two scores.
  bool Uses(ScoreKind kind) const { return score == kind || final_score == kind; }
  /// Throws Error naming a field that is out of range.
  void Check() const;
};

}  // namespace diffsac
