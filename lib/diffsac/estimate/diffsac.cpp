#include "diffsac/diffsac.h"

#include <concepts>
#include <functional>
#include <utility>

#include "diffsac/estimate/estimator.h"
#include "diffsac/estimate/problems_of_inputs.h"
#include "diffsac/problem/tasks.h"

namespace diffsac {
namespace {

using Matrix34 = Eigen::Matrix<double, 3, 4>;

template <class Options>
Estimate Run(const Problem& problem, const Options& options) {
  const EstimateOptions shared = SharedOptions(options);
  return CachedEstimator(problem.task, shared)->Run(problem, shared.seed);
}

/// Parameters are row-major.
template <class Model>
Model ModelOf(const ModelParameters& parameters) {
  constexpr auto kOrder = Model::ColsAtCompileTime == 1 ? Eigen::ColMajor : Eigen::RowMajor;
  using Layout = Eigen::Matrix<double, Model::RowsAtCompileTime, Model::ColsAtCompileTime, kOrder>;
  return Eigen::Map<const Layout>(parameters.data());
}

Verdict VerdictOn(const Estimate& estimate) {
  if (estimate.status != Status::kOk) return Verdict::kFailed;
  if (estimate.MayBeChance()) return Verdict::kUnsupported;
  if (estimate.MayBeWrong()) return Verdict::kUnreliable;
  const Degeneracy degeneracy = estimate.degeneracy;
  if (degeneracy == Degeneracy::kPureRotation || degeneracy == Degeneracy::kStatic) return Verdict::kRotationOnly;
  if (IsUndetermined(degeneracy)) return Verdict::kPlanar;
  return estimate.ambiguous_pose ? Verdict::kAmbiguous : Verdict::kReliable;
}

Diagnostics DiagnosticsOf(const Estimate& estimate) {
  Diagnostics diagnostics;
  if (estimate.status == Status::kOk) diagnostics.log10_nfa = estimate.log10_nfa;
  diagnostics.error_probability = estimate.error_probability;
  diagnostics.degeneracy = estimate.degeneracy;
  diagnostics.cheirality_failure_ratio = estimate.cheirality_failure_ratio;
  diagnostics.mirrored = estimate.mirrored;
  diagnostics.focal_conflict = estimate.focal_conflict;
  diagnostics.scores_ignored = estimate.scores_ignored;
  diagnostics.num_nonfinite = estimate.num_nonfinite;
  diagnostics.num_duplicates = estimate.num_duplicates;
  return diagnostics;
}

template <class Model>
void Take(Estimate estimate, ModelEstimate<Model>* result) {
  result->status = estimate.status;
  result->verdict = VerdictOn(estimate);
  result->diagnostics = DiagnosticsOf(estimate);
  if (result->ok()) result->model = ModelOf<Model>(estimate.model);
  for (const std::uint8_t inlier : estimate.inliers) result->num_inliers += inlier;
  result->inliers = std::move(estimate.inliers);
  result->inlier_threshold = estimate.inlier_threshold;
  result->sigma = estimate.sigma;
  result->inlier_probabilities = std::move(estimate.inlier_probabilities);
  result->posteriors = std::move(estimate.posteriors);
  result->stats = estimate.stats;
}

template <class Result>
Result WithPose(Estimate estimate) {
  Result result;
  result.pose = estimate.pose;
  if (result.pose) result.pose_covariance = std::move(estimate.pose_covariance);
  result.ambiguous_pose = estimate.ambiguous_pose;
  if constexpr (std::derived_from<Result, TwoViewEstimate>) result.focal = estimate.focal;
  Take(std::move(estimate), &result);
  return result;
}

TwoViewEstimate TwoViews(const Problem& problem, const ImageOptions& options) {
  return WithPose<TwoViewEstimate>(Run(problem, options));
}

/// `Description`: of the problem's task.
template <class Description>
UnknownFocalEstimate UnknownFocalViews(const Problem& problem, const FocalOptions& options) {
  Estimate estimate = Run(problem, options);
  CameraPair cameras;
  if (estimate.status == Status::kOk) {
    cameras = Description::CamerasOf(estimate.model, problem);
    estimate.model = Description::PixelModel(estimate.model, problem);
  }
  auto result = WithPose<UnknownFocalEstimate>(std::move(estimate));
  result.cameras = cameras;
  return result;
}

Estimate EstimateMotion(Task task, const Matches3D3D& matches, const RegistrationOptions& options) {
  const CloudFrames frames(task, matches);
  Estimate estimate = Run(RegistrationProblem(task, matches, frames, options), options);
  RestoreMotions(frames.from, frames.to, &estimate);
  estimate.inlier_threshold *= frames.to.unit;
  estimate.sigma *= frames.to.unit;
  return estimate;
}

template <class Model, class Options>
MultiModelEstimate<Model> Multiple(
    const Problem& problem, const Options& options, const std::function<void(Estimate*)>& restore = [](auto*) {}) {
  const EstimateOptions shared = SharedOptions(options);
  Estimate estimate = CachedEstimator(problem.task, shared, true)->Run(problem, shared.seed);
  restore(&estimate);
  MultiModelEstimate<Model> result;
  result.status = estimate.status;
  for (const ModelParameters& model : estimate.instances) result.models.push_back(ModelOf<Model>(model));
  result.assignment = std::move(estimate.assignment);
  result.assignment.resize(estimate.inliers.size());
  result.stats = estimate.stats;
  result.num_nonfinite = estimate.num_nonfinite;
  result.num_duplicates = estimate.num_duplicates;
  return result;
}

}  // namespace

TwoViewEstimate EstimateFundamental(const Matches& matches, const ImageOptions& options) {
  return TwoViews(TwoViewProblem(Task::kFundamental, matches, options), options);
}

TwoViewEstimate EstimateEssential(const Matches& matches, const CameraPair& cameras, const ImageOptions& options) {
  return TwoViews(CalibratedProblem(Task::kEssential, matches, cameras, options), options);
}

TwoViewEstimate EstimateHomography(const Matches& matches, const ImageOptions& options) {
  return TwoViews(TwoViewProblem(Task::kHomography, matches, options), options);
}

TwoViewEstimate EstimateCalibratedHomography(const Matches& matches, const CameraPair& cameras,
                                             const ImageOptions& options) {
  return TwoViews(CalibratedProblem(Task::kHomography, matches, cameras, options), options);
}

UnknownFocalEstimate EstimateSharedFocal(const Matches& matches, const FocalOptions& options) {
  return UnknownFocalViews<SharedFocalTask>(FocalProblem(Task::kSharedFocal, matches, options), options);
}

UnknownFocalEstimate EstimateOneFocal(const Matches& matches, const Eigen::Matrix3d& K1, const FocalOptions& options) {
  return UnknownFocalViews<OneFocalTask>(FocalProblem(Task::kOneFocal, matches, options, &K1), options);
}

UnknownFocalEstimate EstimateTwoFocals(const Matches& matches, const FocalOptions& options) {
  return UnknownFocalViews<TwoFocalsTask>(FocalProblem(Task::kTwoFocals, matches, options), options);
}

AbsolutePoseEstimate EstimateAbsolutePose(const Matches2D3D& matches, const Eigen::Matrix3d& K,
                                          const ImageOptions& options) {
  const SceneFrame frame(matches.points3d);
  Estimate estimate = Run(AbsolutePoseProblem(matches, frame, K, options), options);
  frame.Restore(&estimate);
  return WithPose<AbsolutePoseEstimate>(std::move(estimate));
}

RigidMotionEstimate EstimateRigidMotion(const Matches3D3D& matches, const RegistrationOptions& options) {
  return WithPose<RigidMotionEstimate>(EstimateMotion(Task::kRigid, matches, options));
}

SimilarityEstimate EstimateSimilarity(const Matches3D3D& matches, const RegistrationOptions& options) {
  Estimate estimate = EstimateMotion(Task::kSimilarity, matches, options);
  const double scale = estimate.status == Status::kOk ? ScaleOf(Similarity::Parameters(estimate.model)) : 1.0;
  auto result = WithPose<SimilarityEstimate>(std::move(estimate));
  result.scale = scale;
  return result;
}

LineEstimate EstimateLine(const Points2DView& points, const PointOptions& options) {
  LineEstimate result;
  Take(Run(LineProblem(points, options), options), &result);
  return result;
}

PlaneEstimate EstimatePlane(const Points3DView& points, const PointOptions& options) {
  PlaneEstimate result;
  Take(Run(PlaneProblem(points, options), options), &result);
  return result;
}

MultiModelEstimate<Eigen::Matrix3d> EstimateMultipleFundamentals(const Matches& matches, const ImageOptions& options) {
  return Multiple<Eigen::Matrix3d>(TwoViewProblem(Task::kFundamental, matches, options), options);
}

MultiModelEstimate<Eigen::Matrix3d> EstimateMultipleEssentials(const Matches& matches, const CameraPair& cameras,
                                                               const ImageOptions& options) {
  return Multiple<Eigen::Matrix3d>(CalibratedProblem(Task::kEssential, matches, cameras, options), options);
}

MultiModelEstimate<Eigen::Matrix3d> EstimateMultipleHomographies(const Matches& matches, const ImageOptions& options) {
  return Multiple<Eigen::Matrix3d>(TwoViewProblem(Task::kHomography, matches, options), options);
}

MultiModelEstimate<Matrix34> EstimateMultipleAbsolutePoses(const Matches2D3D& matches, const Eigen::Matrix3d& K,
                                                           const ImageOptions& options) {
  const SceneFrame frame(matches.points3d);
  return Multiple<Matrix34>(AbsolutePoseProblem(matches, frame, K, options), options,
                            [&](Estimate* estimate) { frame.Restore(estimate); });
}

MultiModelEstimate<Matrix34> EstimateMultipleRigidMotions(const Matches3D3D& matches,
                                                          const RegistrationOptions& options) {
  const CloudFrames frames(Task::kRigid, matches);
  return Multiple<Matrix34>(RegistrationProblem(Task::kRigid, matches, frames, options), options,
                            [&](Estimate* estimate) { RestoreMotions(frames.from, frames.to, estimate); });
}

MultiModelEstimate<Eigen::Vector3d> EstimateMultipleLines(const Points2DView& points, const PointOptions& options) {
  return Multiple<Eigen::Vector3d>(LineProblem(points, options), options);
}

MultiModelEstimate<Eigen::Vector4d> EstimateMultiplePlanes(const Points3DView& points, const PointOptions& options) {
  return Multiple<Eigen::Vector4d>(PlaneProblem(points, options), options);
}

}  // namespace diffsac
