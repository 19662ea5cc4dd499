#include "diffsac/estimate/diagnose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diffsac/estimate/error_probability.h"
#include "diffsac/estimate/focal_conflict.h"
#include "diffsac/estimate/point_rows.h"
#include "diffsac/estimate/posteriors.h"
#include "diffsac/estimate/static_overlay.h"
#include "diffsac/estimate/zoomed_motion.h"
#include "diffsac/geometry/parallax.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/cloud_chance.h"
#include "diffsac/problem/plane_pose.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/scores/number_of_false_alarms.h"

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

/// Whether two images that gave no model are one and the same, up to the threshold: all but a tenth of the matches.
bool IsStill(const Problem& problem) {
  const Eigen::Index count = problem.points.rows();
  if (!IsTwoView(problem.task) || problem.points.cols() != 4 || count < MinimalSetSize(problem.task)) return false;
  return 10 * std::ssize(RowsFartherThan(problem, problem.inlier_threshold)) <= count;
}

/// Rows whose score is the median or more.
std::vector<int> SurerHalf(const Problem& problem) {
  Eigen::VectorXd ratios = problem.snn_ratio;
  const auto middle = ratios.begin() + (ratios.size() - 1) / 2;
  std::nth_element(ratios.begin(), middle, ratios.end());
  std::vector<int> rows;
  for (Eigen::Index i = 0; i < ratios.size(); ++i)
    if (problem.snn_ratio[i] <= *middle) rows.push_back(static_cast<int>(i));
  return rows;
}

/// log10_nfa of points that are not of two clouds. A matcher that gives scores looked at all keypoints together:
/// its wrong matches agree with each other, and are not anywhere, so that those just beyond the noise say what chance
/// gives; of all, or of the surer half.
double LogChanceOfPoints(const NormalizedProblem& space, const Estimate& estimate,
                         const std::vector<std::uint8_t>& inliers) {
  const Problem& problem = space.problem();
  if (!problem.scored || !estimate.instances.empty() || !IsTwoView(problem.task))
    return Log10NfaOf(problem, Witnesses(problem, inliers), estimate.inlier_threshold);
  const auto log_chance = [&](const NormalizedProblem& part) {
    const MatchesWithinNoise within = WithinNoise(part, estimate);
    return Log10Nfa(static_cast<int>(part.points().rows()), Witnesses(part.problem(), within.inside),
                    MinimalSetSize(problem.task), within.wrong_share);
  };
  const double of_all = log_chance(space);
  const bool ordered = problem.snn_ratio.size() == problem.points.rows();
  return std::log10(2.0) +
         (ordered ? std::min(of_all, log_chance(PointRows(space, SurerHalf(problem)).space())) : of_all);
}

/// E of a motion, for tests of it.
Eigen::Matrix3d EssentialOf(const RigidMotion& motion) {
  return EssentialFromPose({motion.rotation, motion.translation});
}

/// The motion of the inliers of one model, and what they determine of it.
class Diagnosis {
 public:
  Diagnosis(const NormalizedProblem& space, Estimate* estimate)
      : space_(space), problem_(space.problem()), estimate_(*estimate) {}

  void Run() {
    const bool several = !estimate_.instances.empty();
    if (!several && !estimate_.MayBeChance()) {
      const ParallaxTest test = Verdict();
      estimate_.degeneracy = test.degeneracy;
      estimate_.pure_rotation = test.pure_rotation;
      if (IsUndetermined(test.degeneracy)) {
        // Where t is anything, what lies behind the cameras is so as well.
        estimate_.pose_covariance.reset();
        estimate_.cheirality_failure_ratio = 0.0;
      }
    }
    estimate_.pose = Pose();
    if (several || estimate_.MayBeChance()) return;
    TellAmbiguousPose();
    if (!IsUndetermined(estimate_.degeneracy)) TellFocalConflict(space_, &estimate_);
  }

  std::optional<RigidMotion> Pose() {
    if (estimate_.pure_rotation) return RigidMotion{*estimate_.pure_rotation, Eigen::Vector3d::Zero()};
    if (IsOfPlane()) return PlaneMotions() ? std::optional(PlaneMotions()->pose) : std::nullopt;
    if (IsUndetermined(estimate_.degeneracy)) return std::nullopt;
    return estimate_.pose ? estimate_.pose : PoseOfEstimate(estimate_.model, estimate_.inliers, space_);
  }

 private:
  /// Those of the problem, or that the estimate found.
  std::optional<CameraPair> Cameras() const {
    if (problem_.cameras) return problem_.cameras;
    return DispatchDescription(problem_.task, [&]<class Description>() -> std::optional<CameraPair> {
      if constexpr (requires { Description::CamerasOf(estimate_.model, problem_); })
        return Description::CamerasOf(estimate_.model, problem_);
      return std::nullopt;
    });
  }

  /// Whether the motion is that of a plane: of a homography, and of F that a plane leaves open.
  bool IsOfPlane() const {
    return problem_.cameras && (problem_.task == Task::kHomography || estimate_.degeneracy == Degeneracy::kPlane);
  }

  const std::optional<PlanePoses>& PlaneMotions() {
    if (plane_) return *plane_;
    const PlaneViews views{problem_.points, estimate_.inliers, *problem_.cameras, problem_.inlier_threshold};
    plane_ =
        problem_.task == Task::kHomography ? PosesOfPlane(ModelMatrix(estimate_.model), views) : PosesOfPlane(views);
    return *plane_;
  }

  /// What stands still on the images (a watermark) beside a camera that turned looks like parallax: the verdict is that
  /// of the others where these say that it turned.
  ParallaxTest Verdict() {
    const ParallaxTest test = ParallaxOfEstimate(estimate_.model, estimate_.inliers, space_);
    if (test.degeneracy != Degeneracy::kDetermined) return test;
    if (problem_.task == Task::kHomography) {
      if (!problem_.cameras || !PlaneMotions()) return test;
      const auto& [K1, K2] = *problem_.cameras;
      return TestTurn(NormalizedCoordinates(problem_.points, K1, K2), AsParameters(EssentialOf(PlaneMotions()->pose)),
                      estimate_.inliers);
    }
    const std::vector<int> rows = RowsFartherThan(problem_, kStillReach * estimate_.inlier_threshold);
    std::vector<std::uint8_t> inliers;
    for (const int row : rows) inliers.push_back(estimate_.inliers[static_cast<std::size_t>(row)]);
    if (rows.size() == estimate_.inliers.size() || std::count(inliers.begin(), inliers.end(), 1) < kLeastMoving)
      return test;
    const ParallaxTest of_moving = ParallaxOfEstimate(estimate_.model, inliers, PointRows(space_, rows).space());
    return of_moving.degeneracy == Degeneracy::kPureRotation ? of_moving : test;
  }

  /// Two motions explain matches of one plane. Epipolar geometry finds either, by chance, so that the other is told.
  void TellAmbiguousPose() {
    if (estimate_.pure_rotation || !IsTwoView(problem_.task)) return;
    if (IsOfPlane()) {
      if (PlaneMotions() && PlaneMotions()->ambiguous()) estimate_.ambiguous_pose = PlaneMotions()->other;
      return;
    }
    const auto& pose = estimate_.pose;
    const auto cameras = Cameras();
    if (!pose || !cameras || problem_.task == Task::kFundamental) return;
    const Eigen::Matrix3d f = FundamentalFromEssential(EssentialOf(*pose), cameras->K1, cameras->K2);
    if (TestPlane(problem_.points, AsParameters(f), estimate_.inliers).degeneracy != Degeneracy::kPlane) {
      if (!estimate_.ambiguous_pose) estimate_.ambiguous_pose = MotionOfOtherRatio(space_, estimate_);
      return;
    }
    const PlaneViews views{problem_.points, estimate_.inliers, *cameras, estimate_.inlier_threshold};
    const auto poses = PosesOfPlane(views);
    if (!poses || !poses->other) return;
    const auto degrees = [&](const RigidMotion& motion) {
      return std::max(RotationAngleDegrees(motion.rotation, pose->rotation),
                      DirectionAngleDegrees(motion.translation, pose->translation));
    };
    const RigidMotion& other = degrees(poses->pose) <= degrees(*poses->other) ? *poses->other : poses->pose;
    if (!(LogOdds(*pose, other, views) < std::log(kClearOdds))) return;
    estimate_.ambiguous_pose = other;
    estimate_.pose_covariance.reset();
  }

  const NormalizedProblem& space_;
  const Problem& problem_;
  Estimate& estimate_;
  std::optional<std::optional<PlanePoses>> plane_;  ///< Once they were asked for.
};

}  // namespace

void AddSupport(const PreparedProblem& prepared, Estimate* estimate) {
  const Problem& problem = prepared.problem();
  // Rows that are all alike are many, and determine no model.
  if (estimate->status == Status::kTooFewPoints && prepared.rows().repeated() > 0 &&
      problem.points.rows() + prepared.rows().repeated() >= MinimalSetSize(problem.task))
    estimate->status = Status::kDegenerate;
  if (estimate->status != Status::kOk) {
    estimate->inliers.assign(static_cast<std::size_t>(problem.points.rows()), 0);
    return;
  }
  if (std::isnan(estimate->inlier_threshold)) estimate->inlier_threshold = problem.inlier_threshold;
  std::vector<std::uint8_t> of_first;
  for (const std::int32_t label : estimate->assignment) of_first.push_back(label == 1);
  const std::vector<std::uint8_t>& inliers = estimate->instances.empty() ? estimate->inliers : of_first;
  estimate->log10_nfa = IsOfTwoClouds(problem.task)
                            ? LogChanceMotions(problem.points, estimate->model, inliers, estimate->inlier_threshold)
                            : LogChanceOfPoints(prepared.space(), *estimate, inliers);
}

void Diagnose(const PreparedProblem& prepared, Estimate* estimate) {
  const Problem& problem = prepared.problem();
  if (estimate->status != Status::kOk) {
    estimate->posteriors = PosteriorsOf(prepared.space(), *estimate);
    if (IsStill(problem)) estimate->degeneracy = Degeneracy::kStatic;
    return;
  }
  Diagnosis(prepared.space(), estimate).Run();
  if (estimate->cheirality_failure_ratio > kMostBehind) {
    estimate->log10_nfa = std::numeric_limits<double>::infinity();
    estimate->degeneracy = Degeneracy::kNotTested;
  }
  // Noise does not bound the error of a model that may be of nothing.
  if (estimate->MayBeChance()) estimate->pose_covariance.reset();
  estimate->error_probability = ErrorProbability(problem, *estimate);
  estimate->posteriors = PosteriorsOf(prepared.space(), *estimate);
}

std::optional<RigidMotion> PoseOfEstimate(const Estimate& estimate, const Problem& problem) {
  if (estimate.status != Status::kOk) return std::nullopt;
  if (estimate.pose) return estimate.pose;
  const NormalizedProblem space(problem);
  Estimate given = estimate;
  return Diagnosis(space, &given).Pose();
}

}  // namespace diffsac
