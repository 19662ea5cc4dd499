#include "diffsac/estimators/robust_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/consensus/scores/false_alarms.h"
#include "diffsac/estimators/error_probability.h"
#include "diffsac/estimators/focal_conflict.h"
#include "diffsac/estimators/point_rows.h"
#include "diffsac/estimators/posteriors.h"
#include "diffsac/estimators/static_overlay.h"
#include "diffsac/geometry/parallax.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/cloud_chance.h"
#include "diffsac/problem/plane_pose.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/problem/usable_rows.h"

namespace diffsac {
namespace {

/// How many inliers speak for a model. Matches that share a keypoint are one: a point that many are matched to lies on
/// the epipolar lines of all, and is the image of all by a homography.
int Witnesses(const Problem& problem, const std::vector<std::uint8_t>& inliers) {
  std::vector<int> rows;
  for (std::size_t i = 0; i < inliers.size(); ++i)
    if (inliers[i] == 1) rows.push_back(static_cast<int>(i));
  const int count = static_cast<int>(rows.size());
  if (!IsTwoView(problem.task)) return count;
  const PointMatrix points = problem.points(rows, Eigen::all);
  const Eigen::Index half = points.cols() / 2;
  return std::min(CountDistinct(points.leftCols(half)), CountDistinct(points.rightCols(half)));
}

/// Whether two images that gave no model are one and the same, up to `threshold`: all but a tenth of the matches.
bool IsStill(const Problem& problem, double threshold) {
  const Eigen::Index count = problem.points.rows();
  if (!IsTwoView(problem.task) || problem.points.cols() != 4 || count < MinimalSetSize(problem.task)) return false;
  return 10 * std::ssize(RowsFartherThan(problem, threshold)) <= count;
}

/// Those of the problem, or that the estimate found.
std::optional<CameraPair> CamerasOf(const Estimate& estimate, const Problem& problem) {
  if (problem.cameras) return problem.cameras;
  return DispatchDescription(problem.task, [&]<class Description>() -> std::optional<CameraPair> {
    if constexpr (requires { Description::CamerasOf(estimate.model, problem); })
      return Description::CamerasOf(estimate.model, problem);
    return std::nullopt;
  });
}

/// Whether the motion is that of a plane: of a homography, and of F that a plane leaves open.
bool IsPoseOfPlane(const Estimate& estimate, const Problem& problem) {
  return problem.cameras && (problem.task == Task::kHomography || estimate.translation == Translation::kPlane);
}

std::optional<PlanePoses> PosesOf(const Estimate& estimate, const Problem& problem) {
  if (!problem.cameras) return std::nullopt;
  const PlaneViews views{problem.points, estimate.inliers, *problem.cameras, problem.inlier_threshold};
  return problem.task == Task::kHomography ? PosesOfPlane(ModelMatrix(estimate.model), views) : PosesOfPlane(views);
}

/// E of a motion, for tests of it.
Eigen::Matrix3d EssentialOf(const RigidMotion& motion) {
  return EssentialFromPose({motion.rotation, motion.translation});
}

/// Two motions explain matches of one plane. Epipolar geometry finds either, by chance, so that the other is told.
void TellOtherPose(const Problem& problem, Estimate* estimate) {
  if (estimate->turn || !IsTwoView(problem.task)) return;
  if (IsPoseOfPlane(*estimate, problem)) {
    const auto poses = PosesOf(*estimate, problem);
    if (poses && poses->ambiguous()) estimate->other_pose = poses->other;
    return;
  }
  const auto pose = PoseOfEstimate(*estimate, problem);
  const auto cameras = CamerasOf(*estimate, problem);
  if (!pose || !cameras || problem.task == Task::kFundamental) return;
  const Eigen::Matrix3d f = FundamentalFromEssential(EssentialOf(*pose), cameras->K1, cameras->K2);
  if (TestPlane(problem.points, AsParameters(f), estimate->inliers).translation != Translation::kPlane) return;
  const PlaneViews views{problem.points, estimate->inliers, *cameras, estimate->inlier_threshold};
  const auto poses = PosesOfPlane(views);
  if (!poses || !poses->other) return;
  const auto degrees = [&](const RigidMotion& motion) {
    return std::max(RotationAngleDegrees(motion.rotation, pose->rotation),
                    DirectionAngleDegrees(motion.translation, pose->translation));
  };
  const RigidMotion& other = degrees(poses->pose) <= degrees(*poses->other) ? *poses->other : poses->pose;
  if (!(LogOdds(*pose, other, views) < std::log(kClearOdds))) return;
  estimate->other_pose = other;
  estimate->pose_covariance.reset();
}

/// The verdict on the translation. What stands still on the images (a watermark) beside a camera that turned looks like
/// parallax: the verdict is that of the others where these say that it turned.
ParallaxTest VerdictOf(const Problem& problem, const Estimate& estimate) {
  const ParallaxTest test = ParallaxOfEstimate(estimate.model, estimate.inliers, problem);
  if (test.translation != Translation::kDetermined) return test;
  if (problem.task == Task::kHomography) {
    const auto poses = PosesOf(estimate, problem);
    return poses ? CalibratedParallax(EssentialOf(poses->pose), *problem.cameras, estimate.inliers, problem.points)
                 : test;
  }
  const std::vector<int> rows = RowsFartherThan(problem, kStillReach * estimate.inlier_threshold);
  std::vector<std::uint8_t> inliers;
  for (const int row : rows) inliers.push_back(estimate.inliers[static_cast<std::size_t>(row)]);
  if (rows.size() == estimate.inliers.size() || std::count(inliers.begin(), inliers.end(), 1) < kLeastMoving)
    return test;
  const ParallaxTest of_moving = ParallaxOfEstimate(estimate.model, inliers, PartOf(problem, rows));
  return of_moving.translation == Translation::kTurn ? of_moving : test;
}

/// Rows whose score is the median or more.
std::vector<int> SurerHalf(const Problem& problem) {
  Eigen::VectorXd ratios = problem.match_ratio;
  const auto middle = ratios.begin() + (ratios.size() - 1) / 2;
  std::nth_element(ratios.begin(), middle, ratios.end());
  std::vector<int> rows;
  for (Eigen::Index i = 0; i < ratios.size(); ++i)
    if (problem.match_ratio[i] <= *middle) rows.push_back(static_cast<int>(i));
  return rows;
}

/// log_false_alarms of points that are not of two clouds. A matcher that gives scores looked at all keypoints together:
/// its wrong matches agree with each other, and are not anywhere, so that those just beyond the noise say what chance
/// gives; of all, or of the surer half.
double LogChanceOfPoints(const Problem& problem, const Estimate& estimate, const std::vector<std::uint8_t>& inliers) {
  if (!problem.scored || !estimate.structures.empty() || !IsTwoView(problem.task))
    return LogFalseAlarmsOf(problem, Witnesses(problem, inliers), estimate.inlier_threshold);
  const auto log_chance = [&](const Problem& part) {
    const MatchesWithinNoise within = WithinNoise(part, estimate);
    return LogFalseAlarms(static_cast<int>(part.points.rows()), Witnesses(part, within.inside),
                          MinimalSetSize(part.task), within.wrong_share);
  };
  const double of_all = log_chance(problem);
  const bool ordered = problem.match_ratio.size() == problem.points.rows();
  return std::log10(2.0) + (ordered ? std::min(of_all, log_chance(PartOf(problem, SurerHalf(problem)))) : of_all);
}

/// The verdict on the motion of inliers that are more than chance, and a plane's other motion.
void Diagnose(const Problem& problem, Estimate* estimate) {
  const ParallaxTest test = VerdictOf(problem, *estimate);
  estimate->translation = test.translation;
  estimate->turn = test.turn;
  if (IsUndetermined(test.translation)) {
    // Where t is anything, what lies behind the cameras is so as well.
    estimate->pose_covariance.reset();
    estimate->share_behind = 0.0;
  }
  TellOtherPose(problem, estimate);
  if (!IsUndetermined(estimate->translation)) TellFocalConflict(problem, estimate);
}

/// What every estimate of usable rows says, whatever found it.
void Complete(const UsableRows& rows, Estimate* estimate) {
  const Problem& problem = rows.problem();
  // Rows that are all alike are many, and determine no model.
  if (estimate->status == Status::kTooFewPoints && rows.repeated() > 0 &&
      problem.points.rows() + rows.repeated() >= MinimalSetSize(problem.task))
    estimate->status = Status::kDegenerate;
  if (estimate->status != Status::kOk) {
    estimate->inliers.assign(static_cast<std::size_t>(problem.points.rows()), 0);
    estimate->posteriors = PosteriorsOf(problem, *estimate);
    if (IsStill(problem, problem.inlier_threshold)) estimate->translation = Translation::kStatic;
    return;
  }
  if (std::isnan(estimate->inlier_threshold)) estimate->inlier_threshold = problem.inlier_threshold;
  const bool several = !estimate->structures.empty();
  std::vector<std::uint8_t> of_first;
  for (const std::int32_t label : estimate->assignment) of_first.push_back(label == 1);
  const std::vector<std::uint8_t>& inliers = several ? of_first : estimate->inliers;
  estimate->log_false_alarms = IsOfTwoClouds(problem.task) ? LogChanceMotions(problem.points, estimate->model, inliers,
                                                                              estimate->inlier_threshold)
                                                           : LogChanceOfPoints(problem, *estimate, inliers);
  if (!several && !estimate->MayBeChance()) Diagnose(problem, estimate);
  if (estimate->share_behind > kMostBehind) {
    estimate->log_false_alarms = std::numeric_limits<double>::infinity();
    estimate->translation = Translation::kNotTested;
  }
  // Noise does not bound the error of a model that may be of nothing.
  if (estimate->MayBeChance()) estimate->pose_covariance.reset();
  estimate->error_probability = ErrorProbability(problem, *estimate);
  estimate->posteriors = PosteriorsOf(problem, *estimate);
}

/// Makes an estimate of usable rows one of all rows.
void GiveToAll(const UsableRows& rows, Estimate* estimate) {
  rows.Spread(&estimate->inliers);
  rows.Spread(&estimate->assignment);
  rows.Spread(&estimate->inlier_probabilities);
  rows.Spread(&estimate->posteriors);
  for (std::vector<int>& set : estimate->minimal_sets)
    for (int& row : set) row = rows.RowOf(row);
  estimate->rows_left_out = rows.left_out();
  estimate->repeated_rows = rows.repeated();
}

}  // namespace

std::optional<RigidMotion> PoseOfEstimate(const Estimate& estimate, const Problem& problem) {
  if (estimate.status != Status::kOk) return std::nullopt;
  if (estimate.turn) return RigidMotion{*estimate.turn, Eigen::Vector3d::Zero()};
  if (IsPoseOfPlane(estimate, problem)) {
    const auto poses = PosesOf(estimate, problem);
    return poses ? std::optional(poses->pose) : std::nullopt;
  }
  if (IsUndetermined(estimate.translation)) return std::nullopt;
  return PoseOfEstimate(estimate.model, estimate.inliers, problem);
}

Estimate RobustEstimator::Run(const Problem& problem, std::uint64_t seed) const {
  const UsableRows rows(problem);
  Estimate estimate = DoRun(rows.problem(), seed);
  Complete(rows, &estimate);
  TryMoving(rows.problem(), seed, &estimate);
  GiveToAll(rows, &estimate);
  return estimate;
}

void RobustEstimator::TryMoving(const Problem& problem, std::uint64_t seed, Estimate* estimate) const {
  const std::vector<int> rows = RowsThatMove(problem, *estimate);
  if (rows.empty()) return;
  const SolverSpace whole(problem);
  const PointRows part(whole, rows);
  const Problem& moving = part.space().problem();
  Estimate of_moving = DoRun(moving, seed);
  Complete(UsableRows(moving), &of_moving);
  PreferMoving(rows, std::move(of_moving), estimate);
}

std::vector<Estimate> RobustEstimator::RunBatch(std::span<const Problem* const> problems,
                                                std::span<const std::uint64_t> seeds) const {
  std::vector<UsableRows> rows;
  for (const Problem* problem : problems) rows.emplace_back(*problem);
  std::vector<const Problem*> usable;
  for (const UsableRows& of_problem : rows) usable.push_back(&of_problem.problem());
  std::vector<Estimate> estimates = DoRunBatch(usable, seeds);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    Complete(rows[i], &estimates[i]);
    TryMoving(rows[i].problem(), seeds[i], &estimates[i]);
    GiveToAll(rows[i], &estimates[i]);
  }
  return estimates;
}

std::vector<Estimate> RobustEstimator::DoRunBatch(std::span<const Problem* const> problems,
                                                  std::span<const std::uint64_t> seeds) const {
  std::vector<Estimate> estimates;
  estimates.reserve(problems.size());
  for (std::size_t i = 0; i < problems.size(); ++i) estimates.push_back(DoRun(*problems[i], seeds[i]));
  return estimates;
}

}  // namespace diffsac
