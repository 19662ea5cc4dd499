#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "diffsac/core/status.h"
#include "diffsac/geometry/focal_conflict.h"
#include "diffsac/problem/prepared_problem.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

/// What an estimate cost. Every model that was solved or scored counts, local optimisation and features included.
struct EstimationStats {
  int hypotheses = 0;           ///< Models.
  int unique_minimal_sets = 0;  ///< That were solved.
  double ms_features = 0.0;     ///< Milliseconds for what a network sees.
  double ms_network = 0.0;      ///< Milliseconds of the network.
  double ms_consensus = 0.0;    ///< Milliseconds of the search.
  double ms_total = 0.0;        ///< Milliseconds of the whole estimate.
  std::int64_t iterations = 0;  ///< Minimal sets drawn; 0 for methods that do not tell.
};

/// Adds what another search for the same estimate cost.
void AddCost(const EstimationStats& other, EstimationStats* report);

/// Of points that fit a motion, no larger share is behind its cameras than this if it is one.
inline constexpr double kMostBehind = 0.2;

/// Of models with a greater error_probability most are wrong; of right ones 5 % have one (docs/results/verdicts.md).
inline constexpr double kLikelyWrong = 0.5;

/// The result of one robust estimator on one problem.
struct Estimate {
  Status status = Status::kNoModel;   ///< Whether there is a model, or why not.
  ModelParameters model;              ///< Empty unless status is ok.
  std::vector<std::uint8_t> inliers;  ///< N values: residual <= inlier_threshold under `model`; 0 without one.
  /// Of these, in the data's unit: the problem's, or less where a method finds the noise itself.
  double inlier_threshold = std::numeric_limits<double>::quiet_NaN();
  /// log10 of the number of models that chance would give with as many inliers (Log10NfaOf; of several
  /// structures: as those of the first); NaN without a model.
  double log10_nfa = std::numeric_limits<double>::quiet_NaN();
  /// E and F: how likely the motion is off by more than 10° (ErrorProbability); NaN for others.
  double error_probability = std::numeric_limits<double>::quiet_NaN();
  double score = 0.0;  ///< Of the score that chose the model.
  /// σ of one coordinate of the inliers' residuals, in the data's unit; NaN for methods that do not estimate it.
  double sigma = std::numeric_limits<double>::quiet_NaN();
  /// Two views: whether the inliers determine the translation (the model, where there are no cameras). Where they do
  /// not, `model` is only one of those that explain them, and pose_covariance is absent.
  Degeneracy degeneracy = Degeneracy::kNotTested;
  /// Where the camera turned in place or stood still: its rotation.
  std::optional<Eigen::Matrix3d> pure_rotation = {};
  /// Two views: the second camera seen from the first, |t| = 1, chosen by cheirality where cameras are known or found;
  /// t = 0 of a camera that only turned or stood still (`turn`); of a homography or a plane, by cameras, PosesOfPlane;
  /// absent where a line, or a plane without cameras, leaves it open. Absolute poses, motions of clouds: that of
  /// `model`.
  std::optional<RigidMotion> pose = {};
  /// Two views of unknown focal length, and F that is of one camera (PutCameraBehind): what became of it.
  std::optional<FocalEstimate> focal = {};
  /// Two views: where the focal lengths that were given, or a prior of them, contradict the matches (focal_conflict.h).
  std::optional<FocalConflict> focal_conflict = {};
  /// Of `pose`, 6 × 6 in the order (ω, t): R = exp([ω]ₓ) R̂, ω in radians in the frame of
  /// the (second) camera; t in units of its length (two views: of rank 5) or of the scene (absolute pose). Absent where
  /// a focal length is unknown (docs/estimates.md), for other tasks, for methods that end without a refinement, and
  /// where the inliers do not determine the motion (CovarianceOfFit, `degeneracy`).
  std::optional<Eigen::MatrixXd> pose_covariance = {};
  /// E, unknown focal lengths, absolute pose: of the points that fit, the share that lies behind a camera. They are no
  /// inliers. Much of it where an image is mirrored, say: beyond kMostBehind, log10_nfa is infinite.
  double cheirality_failure_ratio = 0.0;
  /// Of points on a plane: another pose that explains them as well, beside that of `model`
  /// (AbsolutePose::OtherMinimum; of two views PosesOfPlane). Then pose_covariance is absent. Of unknown focal lengths
  /// MotionOfOtherRatio as well.
  std::optional<RigidMotion> ambiguous_pose = {};
  /// N values, what a network says of each point before the search: how likely it is an inlier (`diffsac`), or in
  /// proportion to that (`ng_ransac`, `clnet`); empty: none.
  std::vector<float> inlier_probabilities;
  /// N values, how likely each point is right under `model` (PosteriorsOf); empty of several structures.
  std::vector<float> posteriors;
  /// The first (up to 20) minimal sets that were solved, in their order, for reports; empty for methods that have none
  /// or do not tell.
  std::vector<std::vector<int>> minimal_sets;
  /// Of estimators that look for several structures, the models that were found, that of most points first, which is
  /// `model` too; `inliers` are those of any of them. Empty for others, and where nothing was found.
  std::vector<ModelParameters> instances;
  /// The points' assignment to `instances`, N values: 0 for a point of none of them, k ≥ 1 for one of instances[k −
  /// 1].
  std::vector<std::int32_t> assignment;
  /// How sure the network was that chose `instances`, of each beside those before it (`instances.search: chosen`), in
  /// [0, 1]; empty for others.
  std::vector<double> instance_values;
  EstimationStats stats;  ///< What it cost.
  /// Rows that were not used because a value is not finite: of no model, of probability 0.
  int num_nonfinite = 0;
  /// Rows that equal another one, which counts once in all that is found and said of N points; N values have all.
  int num_duplicates = 0;
  /// Whether the ratios or scores of the matches were found to be worse than none, and were not used (score_check.h).
  bool scores_ignored = false;
  /// Two views: whether the matches fit the mirror image of the second one (mirror_check.h), and this model by chance.
  bool mirrored = false;
  /// Whether points without any structure would give a model like this: it is better not relied upon.
  bool MayBeChance() const { return log10_nfa > 0.0; }
  /// Whether another search cannot find much more: a model that is more than chance, with its points before the
  /// cameras.
  bool IsSure() const { return status == Status::kOk && !MayBeChance() && cheirality_failure_ratio <= kMostBehind; }
  /// Whether models like this are wrong too often to rely on.
  bool MayBeWrong() const { return MayBeChance() || error_probability > kLikelyWrong || focal_conflict; }
};

/// What a learned estimator's network was made by.
struct TrainingFacts {
  std::int64_t parameters = 0;   ///< Of the network.
  std::int64_t samples = 0;      ///< Problems that these weights were trained on: steps times the batch.
  std::int64_t run_samples = 0;  ///< The same of the whole run, of which they are the best.
  std::string start;             ///< The network that the run began with, by its folder's name; empty: none.
};

/// Estimates models in the presence of outliers: prepares the problem, searches, searches once more where the first
/// search leaves doubts and the options ask for it (second_search.h), and diagnoses the better result (diagnose.h).
/// Functions of diffsac.h, methods of tables and programs all run this. Thread-safe: `Run` is const and all randomness
/// comes from `seed`.
class RobustEstimator {
 public:
  virtual ~RobustEstimator() = default;
  /// Never throws for bad data; the status says what was wrong.
  Estimate Run(const Problem& problem, std::uint64_t seed) const;
  /// Same results as one by one (bit for bit, or within the stated tolerance for a network's outputs).
  std::vector<Estimate> RunBatch(std::span<const Problem* const> problems, std::span<const std::uint64_t> seeds) const;
  /// Problems that a batch should hold; 1 when batching brings nothing.
  virtual int PreferredBatch() const { return 1; }
  /// Whether `inlier_probabilities` mean what they say, rather than be only in proportion to it.
  virtual bool GivesProbabilities() const { return false; }
  /// Whether noise is searched for far from a threshold that is not the default one, and doubts lead to a second
  /// search.
  virtual bool SearchesAgain() const { return false; }
  /// Nothing for estimators that don't learn.
  virtual std::optional<TrainingFacts> Training() const { return std::nullopt; }
  /// Who searches where ratios or scores turn out to be worse than none: an estimator of matches without any, whose
  /// network has not learned them. By default this one.
  using Other = std::function<const RobustEstimator&()>;
  void SetWithoutScores(Other other) { without_scores_ = std::move(other); }

 private:
  /// One search, of finite and distinct rows.
  virtual Estimate DoRun(const NormalizedProblem& space, std::uint64_t seed) const = 0;
  /// By default one by one.
  virtual std::vector<Estimate> DoRunBatch(std::span<const NormalizedProblem> spaces,
                                           std::span<const std::uint64_t> seeds) const;
  Estimate Finish(const PreparedProblem& prepared, std::uint64_t seed, Estimate estimate) const;

  Other without_scores_;
};

}  // namespace diffsac
