#include "lab/images/estimate_pair.h"

#include <algorithm>

#include "diffsac/geometry/calibration.h"
#include "diffsac/problem/within_size.h"
#include "diffsac/ransac/consensus_options.h"

namespace diffsac {
namespace {

/// Of cameras in general: the standard deviation of log f that diffsac.h takes where nothing is known.
const double kAnyLogSigma = ConsensusOptions().focal_log_sigma;
constexpr int kFocalIterations = 1000;

/// Unknown where the lens, which was taken out, had many points beyond it.
ImageSize SizeWithin(const ImageSize& size, const Points2DView& points) {
  try {
    RequireWithin(size, points, "size");
    return size;
  } catch (const Error&) {
    return {};
  }
}

/// A problem has scores as 1 - score in its ratios.
template <class Input>
void GiveScores(const Problem& problem, Input* matches) {
  if (problem.scored)
    matches->scores = 1.0 - problem.snn_ratio.array();
  else
    matches->snn_ratio = problem.snn_ratio;
}

Matches MatchesOf(const Problem& problem) {
  Matches matches{.points1 = problem.points.leftCols(2),
                  .points2 = problem.points.rightCols(2),
                  .size1 = SizeWithin(problem.size1, problem.points.leftCols(2)),
                  .size2 = SizeWithin(problem.size2, problem.points.rightCols(2)),
                  .scale_rotation_changes = problem.scale_rotation_changes};
  GiveScores(problem, &matches);
  return matches;
}

/// A prior of the first image alone is not the second one's.
template <class Options>
Options SharedOptionsOf(const PairOptions& asked, const Problem& problem) {
  Options options;
  options.max_residual = asked.threshold_px;
  options.max_iterations = asked.max_iterations;
  options.min_iterations = asked.min_iterations;
  options.confidence = asked.confidence;
  options.seed = asked.seed;
  options.prior = problem.camera_prior1.focal;
  options.prior2 = problem.camera_prior2.focal;
  if (problem.task != Task::kSharedFocal && options.prior && !options.prior2)
    options.prior2 = FocalPrior{kMedianFocal * std::max(problem.size2.width, problem.size2.height), kAnyLogSigma};
  return options;
}

ImageOptions ImageOptionsOf(const PairOptions& asked, const Problem& problem) {
  auto options = SharedOptionsOf<ImageOptions>(asked, problem);
  options.guidance = asked.guidance;
  options.models_folder = asked.models_folder;
  return options;
}

/// All samples are drawn, which costs milliseconds.
FocalOptions FocalOptionsOf(const PairOptions& asked, const Problem& problem) {
  auto options = SharedOptionsOf<FocalOptions>(asked, problem);
  if (!asked.min_iterations && !asked.confidence)
    options.min_iterations = std::min(asked.max_iterations.value_or(kFocalIterations), kFocalIterations);
  return options;
}

AbsolutePoseEstimate EstimateScenePose(const Problem& problem, const ImageOptions& options) {
  Matches2D3D matches{.points3d = problem.points.leftCols(3), .points2d = problem.points.rightCols(2)};
  GiveScores(problem, &matches);
  return EstimateAbsolutePose(matches, problem.cameras.value().K1, options);
}

/// All that estimates of any model have, but for the model.
template <class Model>
void Take(PoseEstimate<Model> from, PairEstimate* to) {
  to->status = from.status;
  to->verdict = from.verdict;
  to->inliers = std::move(from.inliers);
  to->num_inliers = from.num_inliers;
  to->inlier_threshold = from.inlier_threshold;
  to->sigma = from.sigma;
  to->inlier_probabilities = std::move(from.inlier_probabilities);
  to->posteriors = std::move(from.posteriors);
  to->diagnostics = from.diagnostics;
  to->stats = from.stats;
  to->pose = from.pose;
  to->pose_covariance = std::move(from.pose_covariance);
  to->ambiguous_pose = from.ambiguous_pose;
}

/// The functions of diffsac.h, one for each task.
PairEstimate Estimated(const Problem& problem, const PairOptions& options) {
  PairEstimate estimate;
  TwoViewEstimate& two_views = estimate;
  UnknownFocalEstimate& with_focal = estimate;
  switch (problem.task) {
    case Task::kEssential:
      two_views = EstimateEssential(MatchesOf(problem), problem.cameras.value(), ImageOptionsOf(options, problem));
      break;
    case Task::kFundamental:
      two_views = EstimateFundamental(MatchesOf(problem), ImageOptionsOf(options, problem));
      break;
    case Task::kHomography:
      two_views = problem.cameras ? EstimateCalibratedHomography(MatchesOf(problem), *problem.cameras,
                                                                 ImageOptionsOf(options, problem))
                                  : EstimateHomography(MatchesOf(problem), ImageOptionsOf(options, problem));
      break;
    case Task::kSharedFocal:
      with_focal = EstimateSharedFocal(MatchesOf(problem), FocalOptionsOf(options, problem));
      break;
    case Task::kTwoFocals:
      with_focal = EstimateTwoFocals(MatchesOf(problem), FocalOptionsOf(options, problem));
      break;
    case Task::kAbsolutePose:
      Take(EstimateScenePose(problem, ImageOptionsOf(options, problem)), &estimate);
      break;
    default:
      throw Error(ToString(problem.task) + ": no task of two images");
  }
  return estimate;
}

FocalSource SourceOf(const ImagePair& pair, int image) {
  const Problem& problem = pair.example.problem;
  const auto& focal = pair.estimate.focal;
  if (problem.cameras) return FocalSource::kGiven;
  if (focal && focal->observable[image]) return FocalSource::kMatches;
  const CameraPriorHint& hint = image == 0 ? problem.camera_prior1 : problem.camera_prior2;
  return hint.focal ? pair.hints_from[image] : FocalSource::kPrior;
}

}  // namespace

void EstimatePair(const PairOptions& options, ImagePair* pair) {
  Problem& problem = pair->example.problem;
  problem.task = options.task;
  PairEstimate& estimate = pair->estimate = Estimated(problem, options);
  estimate.task = options.task;
  estimate.seed = options.seed;
  if (!problem.scored && !FindsFocals(options.task) && options.task != Task::kAbsolutePose)
    estimate.guidance = options.guidance;
  estimate.matrix = estimate.model;
  if (FindsFocals(options.task) && estimate.ok())
    estimate.matrix = (estimate.cameras.K2.transpose() * estimate.model * estimate.cameras.K1).normalized();
  for (int k = 0; k < 2; ++k) estimate.focal_from[k] = SourceOf(*pair, k);
  pair->done = true;
}

}  // namespace diffsac
