#include "diffsac/diffsac.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "diffsac/estimators/cloud_resolution.h"
#include "diffsac/estimators/pixel_length.h"
#include "diffsac/estimators/presets.h"
#include "diffsac/estimators/require.h"
#include "diffsac/estimators/scene_frame.h"
#include "diffsac/geometry/calibration.h"
#include "diffsac/problem/keypoint_similarity.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/problem/within_size.h"

namespace diffsac {
namespace {

using ImagePointsOf = Eigen::Matrix<double, Eigen::Dynamic, 2>;

/// asked: whether somebody asked for the problem's threshold.
Estimate Run(const Problem& problem, const EstimateOptions& options, bool asked = true) {
  return KeptEstimator(problem.task, options)->Run(problem, options.seed, asked);
}

void RequireOneEach(Eigen::Index rows, Eigen::Index points, const char* name) {
  Require(rows == 0 || rows == points, name,
          "one for each of " + std::to_string(points) + " points, or none, got " + std::to_string(rows));
}

/// Of points that are not finite, which are left out, they may be anything.
void RequireShares(const Eigen::VectorXd& values, const PointMatrix& points, const char* name, const char* what) {
  constexpr double kMost = 1.0 + 1e-6;  // Rounded from single precision.
  RequireOneEach(values.size(), points.rows(), name);
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (!(values[i] >= 0.0 && values[i] <= kMost) && points.row(i).allFinite())
      throw Error(std::string(name) + ": expected " + what + ", got " + std::to_string(values[i]) + " in row " +
                  std::to_string(i));
}

/// `input`: Matches, ScenePoints or CloudMatches.
template <class Input>
void SetRatiosOrScores(const Input& input, Problem* problem) {
  problem->scored = input.scores.size() > 0;
  Require(!problem->scored || input.match_ratios.size() == 0, "scores", "none beside match_ratios: one of them");
  RequireShares(input.match_ratios, problem->points, "match_ratios",
                "the nearest distance over the second-nearest, from 0 to 1, lower is better");
  RequireShares(input.scores, problem->points, "scores", "what a matcher says, from 0 to 1, higher is better");
  problem->match_ratio = input.match_ratios;
  if (problem->scored) problem->match_ratio = (1.0 - input.scores.array()).max(0.0);
}

void SetSimilarities(const PointMatrix& similarities, Problem* problem) {
  RequireOneEach(similarities.rows(), problem->points.rows(), "similarities");
  problem->similarities = similarities;
  for (Eigen::Index i = 0; i < similarities.rows(); ++i) {
    Require(similarities.row(i).allFinite() || !problem->points.row(i).allFinite(), "similarities", "finite values");
    problem->similarities.row(i) = SimilarityOf({0.0, 0.0}, similarities.row(i));
  }
}

ImageSize CheckedSize(const ImageSize& size, const ImagePointsOf& points, const char* name) {
  Require(size.known() || size == ImageSize{}, name, "width and height in pixels, above 0, or neither");
  RequireWithin(size, points, name);
  return size;
}

/// What was asked for, or what is usual, in the unit of points whose pixel is so long (PixelLength).
double ResidualOr(const ImageOptions& options, Task task, double pixel) {
  options.Check();
  return options.max_residual_px > 0.0 ? options.max_residual_px : UsualThreshold(task) * pixel;
}

double ResidualOr(const ImageOptions& options, Task task, const Matches& matches) {
  return ResidualOr(options, task, LengthInResiduals(task, matches.points1, matches.points2, PixelLength));
}

Problem ProblemOf(Task task, const Matches& matches, double max_residual_px) {
  const Eigen::Index count = matches.points1.rows();
  Require(matches.points2.rows() == count, "points2",
          "as many rows as points1, " + std::to_string(count) + ", got " + std::to_string(matches.points2.rows()));
  Problem problem;
  problem.task = task;
  problem.inlier_threshold = max_residual_px;
  problem.points.resize(count, 4);
  problem.points << matches.points1, matches.points2;
  SetRatiosOrScores(matches, &problem);
  SetSimilarities(matches.similarities, &problem);
  problem.size1 = CheckedSize(matches.size1, matches.points1, "size1");
  problem.size2 = CheckedSize(matches.size2, matches.points2, "size2");
  return problem;
}

Problem ProblemOf(const ScenePoints& points, const SceneFrame& frame, const Eigen::Matrix3d& K,
                  double max_residual_px) {
  const Eigen::Index count = points.points3d.rows();
  Require(points.points2d.rows() == count, "points2d",
          "as many rows as points3d, " + std::to_string(count) + ", got " + std::to_string(points.points2d.rows()));
  Problem problem;
  problem.task = Task::kAbsolutePose;
  problem.inlier_threshold = max_residual_px;
  problem.points.resize(count, 5);
  problem.points << frame.Apply(points.points3d), points.points2d;
  SetRatiosOrScores(points, &problem);
  const Eigen::Matrix3d checked = CheckedCalibration(K, "K");
  problem.cameras = CameraPair{checked, checked};
  return problem;
}

/// Each cloud in a frame of its own, of a rigid motion in one unit.
struct CloudFrames {
  SceneFrame from, to;
  CloudFrames(Task task, const CloudMatches& matches) : from(matches.points1), to(matches.points2) {
    if (task == Task::kRigid) from.unit = to.unit;
  }
};

Problem ProblemOf(Task task, const CloudMatches& matches, const CloudFrames& frames, const CloudOptions& options) {
  constexpr double kResolutions = 2.0;
  options.Check();
  const Eigen::Index count = matches.points1.rows();
  Require(matches.points2.rows() == count, "points2",
          "as many rows as points1, " + std::to_string(count) + ", got " + std::to_string(matches.points2.rows()));
  Problem problem;
  problem.task = task;
  problem.points.resize(count, 6);
  problem.points << frames.from.Apply(matches.points1), frames.to.Apply(matches.points2);
  double distance = options.max_distance;
  if (distance == 0.0) distance = kResolutions * CloudResolution(matches.points2);
  problem.inlier_threshold = distance > 0.0 ? distance / frames.to.unit : 1.0;
  SetRatiosOrScores(matches, &problem);
  return problem;
}

template <class Points>
Problem ProblemOf(Task task, const Points& points, const PointOptions& options) {
  options.Check();
  Problem problem;
  problem.task = task;
  problem.inlier_threshold = options.max_distance;
  problem.points = points;
  return problem;
}

/// Parameters are row-major.
template <class Model>
Model ModelOf(const ModelParameters& parameters) {
  constexpr auto kOrder = Model::ColsAtCompileTime == 1 ? Eigen::ColMajor : Eigen::RowMajor;
  using Layout = Eigen::Matrix<double, Model::RowsAtCompileTime, Model::ColsAtCompileTime, kOrder>;
  return Eigen::Map<const Layout>(parameters.data());
}

template <class Result>
void Take(Estimate estimate, Result* result) {
  using Model = decltype(result->model);
  result->status = estimate.status;
  if (result->ok()) result->model = ModelOf<Model>(estimate.model);
  for (const std::uint8_t inlier : estimate.inliers) result->num_inliers += inlier;
  result->inliers = std::move(estimate.inliers);
  result->inlier_threshold = estimate.inlier_threshold;
  result->noise_scale = estimate.noise_scale;
  result->log_false_alarms = estimate.log_false_alarms;
  result->inlier_probabilities = std::move(estimate.inlier_probabilities);
  result->posteriors = std::move(estimate.posteriors);
  result->cost = estimate.report;
  result->rows_left_out = estimate.rows_left_out;
  result->repeated_rows = estimate.repeated_rows;
  result->scores_ignored = estimate.scores_ignored;
}

/// What the two kinds of motions between clouds share; the estimate's other_pose stays.
template <class Result>
Estimate EstimateMotion(Task task, const CloudMatches& matches, const CloudOptions& options, Result* result) {
  const CloudFrames frames(task, matches);
  Estimate estimate = Run(ProblemOf(task, matches, frames, options), options);
  RestoreMotions(frames.from, frames.to, &estimate);
  estimate.inlier_threshold *= frames.to.unit;
  estimate.noise_scale *= frames.to.unit;
  result->covariance = estimate.pose_covariance;
  Take(estimate, result);
  return estimate;
}

TwoViewEstimate TwoViews(const Problem& problem, const ImageOptions& options) {
  Estimate estimate = Run(problem, options, options.max_residual_px > 0.0);
  TwoViewEstimate result;
  if (estimate.status == Status::kOk && problem.cameras) result.pose = PoseOfEstimate(estimate, problem);
  if (result.pose) result.pose_covariance = estimate.pose_covariance;
  result.other_pose = estimate.other_pose;
  result.translation = estimate.translation;
  result.error_probability = estimate.error_probability;
  result.focal_conflict = estimate.focal_conflict;
  result.mirrored = estimate.mirrored;
  result.share_behind = estimate.share_behind;
  Take(std::move(estimate), &result);
  return result;
}

/// `Description`: of the problem's task.
template <class Description>
SharedFocalEstimate UnknownFocalViews(const Problem& problem, const ImageOptions& options) {
  Estimate estimate = Run(problem, options, options.max_residual_px > 0.0);
  SharedFocalEstimate result;
  result.focal = estimate.focal;
  result.translation = estimate.translation;
  result.error_probability = estimate.error_probability;
  result.focal_conflict = estimate.focal_conflict;
  result.mirrored = estimate.mirrored;
  result.share_behind = estimate.share_behind;
  if (estimate.status == Status::kOk) {
    result.pose = PoseOfEstimate(estimate, problem);
    result.other_pose = estimate.other_pose;
    result.cameras = Description::CamerasOf(estimate.model, problem);
    estimate.model = Description::PixelModel(estimate.model, problem);
  }
  Take(std::move(estimate), &result);
  return result;
}

/// What no lens has sees 180 degrees, or nothing.
void RequireOfCamera(const std::optional<FocalPrior>& prior, const ImageSize& size, const std::string& name) {
  constexpr double kLeast = 0.1, kMost = 100.0;
  if (!prior || !size.known()) return;
  const double longer = std::max(size.width, size.height), share = prior->focal / longer;
  Require(share >= kLeast && share <= kMost, name + ".focal",
          "pixels, from " + std::to_string(kLeast * longer) + " to " + std::to_string(kMost * longer) +
              " of an image of this size");
}

Problem FocalProblem(Task task, const Matches& matches, const FocalOptions& options) {
  Problem problem = ProblemOf(task, matches, ResidualOr(options, task, matches));
  problem.hint1.principal_point = options.principal_point1;
  problem.hint2.principal_point = options.principal_point2;
  problem.hint1.focal = options.prior;
  problem.hint2.focal = options.prior2 ? options.prior2 : options.prior;
  RequireOfCamera(problem.hint1.focal, problem.size1, "prior");
  RequireOfCamera(problem.hint2.focal, problem.size2, options.prior2 ? "prior2" : "prior");
  // Of one unknown focal length, the second image's, K1 says all of the first.
  const bool both = task != Task::kOneFocal;
  Require(!both || options.principal_point1.has_value() || problem.size1.known(), "size1",
          "the image's size, or principal_point1");
  Require(options.principal_point2.has_value() || problem.size2.known(), "size2",
          "the image's size, or principal_point2");
  Require(options.prior.has_value() || ((!both || problem.size1.known()) && problem.size2.known()), "prior",
          "a focal length, or the images' sizes");
  return problem;
}

template <class Model>
ModelsEstimate<Model> Several(
    const Problem& problem, const EstimateOptions& options,
    const std::function<void(Estimate*)>& restore = [](auto*) {}) {
  Estimate estimate = KeptEstimator(problem.task, options, true)->Run(problem, options.seed);
  restore(&estimate);
  ModelsEstimate<Model> result;
  result.status = estimate.status;
  for (const ModelParameters& model : estimate.structures) result.models.push_back(ModelOf<Model>(model));
  result.assignment = std::move(estimate.assignment);
  result.assignment.resize(estimate.inliers.size());
  result.cost = estimate.report;
  result.rows_left_out = estimate.rows_left_out;
  result.repeated_rows = estimate.repeated_rows;
  return result;
}

/// A matrix of other points: pixels with the matrix of normalised coordinates, or an inverse, see all to the side.
void RequireInView(const Eigen::Matrix3d& K, const ImagePointsOf& points, const char* name) {
  constexpr double kMostAside = 20.0;  // The tangent of 87 degrees.
  const Eigen::Matrix3d inverse = K.inverse();
  const Eigen::VectorXd aside =
      ((inverse.topLeftCorner<2, 2>() * points.transpose()).colwise() + inverse.topRightCorner<2, 1>())
          .colwise()
          .norm();
  if (Quantile(aside, 0.5) > kMostAside)
    throw Error(std::string(name) +
                ": expected the calibration matrix of these points, but it sees most of them at more than 87 degrees "
                "from its axis: it is in another unit, or inverted");
}

Problem EssentialProblem(const Matches& matches, const CameraPair& cameras, const ImageOptions& options) {
  Problem problem = ProblemOf(Task::kEssential, matches, ResidualOr(options, Task::kEssential, matches));
  problem.cameras = CameraPair{CheckedCalibration(cameras.K1, "K1"), CheckedCalibration(cameras.K2, "K2")};
  RequireInView(problem.cameras->K1, matches.points1, "K1");
  RequireInView(problem.cameras->K2, matches.points2, "K2");
  return problem;
}

}  // namespace

void ImageOptions::Check() const {
  EstimateOptions::Check();
  Require(max_residual_px >= 0.0 && std::isfinite(max_residual_px), "max_residual_px", "pixels, 0 for the default");
}

void FocalOptions::Check() const {
  ImageOptions::Check();
  Require(!principal_point1 || principal_point1->allFinite(), "principal_point1", "finite pixels");
  Require(!principal_point2 || principal_point2->allFinite(), "principal_point2", "finite pixels");
  for (const auto& [name, given] : {std::pair("prior", &prior), std::pair("prior2", &prior2)}) {
    if (!given->has_value()) continue;
    const auto& [focal, log_sigma] = given->value();
    Require(focal > 0.0 && std::isfinite(focal), std::string(name) + ".focal", "pixels, above 0");
    Require(log_sigma > 0.0 && std::isfinite(log_sigma), std::string(name) + ".log_sigma",
            "a standard deviation of log f, above 0");
  }
}

void CloudOptions::Check() const {
  EstimateOptions::Check();
  Require(max_distance >= 0.0 && std::isfinite(max_distance), "max_distance",
          "a distance in the second cloud's unit, 0 for the default");
}

void PointOptions::Check() const {
  EstimateOptions::Check();
  Require(max_distance > 0.0 && std::isfinite(max_distance), "max_distance", "a distance above 0, in the points' unit");
}

TwoViewEstimate EstimateFundamental(const Matches& matches, const ImageOptions& options) {
  return TwoViews(ProblemOf(Task::kFundamental, matches, ResidualOr(options, Task::kFundamental, matches)), options);
}

TwoViewEstimate EstimateEssential(const Matches& matches, const CameraPair& cameras, const ImageOptions& options) {
  return TwoViews(EssentialProblem(matches, cameras, options), options);
}

SharedFocalEstimate EstimateSharedFocal(const Matches& matches, const FocalOptions& options) {
  options.Check();
  return UnknownFocalViews<SharedFocalTask>(FocalProblem(Task::kSharedFocal, matches, options), options);
}

SharedFocalEstimate EstimateOneFocal(const Matches& matches, const Eigen::Matrix3d& K1, const FocalOptions& options) {
  options.Check();
  Problem problem = FocalProblem(Task::kOneFocal, matches, options);
  problem.hint1.K = CheckedCalibration(K1, "K1");
  return UnknownFocalViews<OneFocalTask>(problem, options);
}

SharedFocalEstimate EstimateTwoFocals(const Matches& matches, const FocalOptions& options) {
  options.Check();
  return UnknownFocalViews<TwoFocalsTask>(FocalProblem(Task::kTwoFocals, matches, options), options);
}

TwoViewEstimate EstimateHomography(const Matches& matches, const ImageOptions& options) {
  return TwoViews(ProblemOf(Task::kHomography, matches, ResidualOr(options, Task::kHomography, matches)), options);
}

AbsolutePoseEstimate EstimateAbsolutePose(const ScenePoints& points, const Eigen::Matrix3d& K,
                                          const ImageOptions& options) {
  AbsolutePoseEstimate result;
  const SceneFrame frame(points.points3d);
  const double residual = ResidualOr(options, Task::kAbsolutePose, PixelLength(points.points2d));
  Estimate estimate = Run(ProblemOf(points, frame, K, residual), options);
  frame.Restore(&estimate);
  result.pose_covariance = estimate.pose_covariance;
  result.share_behind = estimate.share_behind;
  result.other_pose = estimate.other_pose;
  Take(std::move(estimate), &result);
  if (result.ok()) result.pose = {result.model.leftCols<3>(), result.model.col(3)};
  return result;
}

RigidMotionEstimate EstimateRigidMotion(const CloudMatches& matches, const CloudOptions& options) {
  RigidMotionEstimate result;
  result.other_motion = EstimateMotion(Task::kRigid, matches, options, &result).other_pose;
  if (result.ok()) result.motion = {result.model.leftCols<3>(), result.model.col(3)};
  return result;
}

SimilarityEstimate EstimateSimilarity(const CloudMatches& matches, const CloudOptions& options) {
  SimilarityEstimate result;
  const Estimate estimate = EstimateMotion(Task::kSimilarity, matches, options, &result);
  if (!result.ok()) return result;
  result.scale = ScaleOf(Similarity::Parameters(estimate.model));
  result.motion = {result.model.leftCols<3>() / result.scale, result.model.col(3)};
  return result;
}

LineEstimate EstimateLine(const Eigen::Matrix<double, Eigen::Dynamic, 2>& points, const PointOptions& options) {
  LineEstimate result;
  Take(Run(ProblemOf(Task::kLine, points, options), options), &result);
  return result;
}

PlaneEstimate EstimatePlane(const Eigen::Matrix<double, Eigen::Dynamic, 3>& points, const PointOptions& options) {
  PlaneEstimate result;
  Take(Run(ProblemOf(Task::kPlane, points, options), options), &result);
  return result;
}

ModelsEstimate<Eigen::Matrix3d> EstimateFundamentals(const Matches& matches, const ImageOptions& options) {
  return Several<Eigen::Matrix3d>(
      ProblemOf(Task::kFundamental, matches, ResidualOr(options, Task::kFundamental, matches)), options);
}

ModelsEstimate<Eigen::Matrix3d> EstimateEssentials(const Matches& matches, const CameraPair& cameras,
                                                   const ImageOptions& options) {
  return Several<Eigen::Matrix3d>(EssentialProblem(matches, cameras, options), options);
}

ModelsEstimate<Eigen::Matrix3d> EstimateHomographies(const Matches& matches, const ImageOptions& options) {
  return Several<Eigen::Matrix3d>(
      ProblemOf(Task::kHomography, matches, ResidualOr(options, Task::kHomography, matches)), options);
}

ModelsEstimate<Eigen::Matrix<double, 3, 4>> EstimateAbsolutePoses(const ScenePoints& points, const Eigen::Matrix3d& K,
                                                                  const ImageOptions& options) {
  const SceneFrame frame(points.points3d);
  const double residual = ResidualOr(options, Task::kAbsolutePose, PixelLength(points.points2d));
  return Several<Eigen::Matrix<double, 3, 4>>(ProblemOf(points, frame, K, residual), options,
                                              [&](Estimate* estimate) { frame.Restore(estimate); });
}

ModelsEstimate<Eigen::Matrix<double, 3, 4>> EstimateRigidMotions(const CloudMatches& matches,
                                                                 const CloudOptions& options) {
  const CloudFrames frames(Task::kRigid, matches);
  return Several<Eigen::Matrix<double, 3, 4>>(
      ProblemOf(Task::kRigid, matches, frames, options), options,
      [&](Estimate* estimate) { RestoreMotions(frames.from, frames.to, estimate); });
}

ModelsEstimate<Eigen::Vector3d> EstimateLines(const Eigen::Matrix<double, Eigen::Dynamic, 2>& points,
                                              const PointOptions& options) {
  return Several<Eigen::Vector3d>(ProblemOf(Task::kLine, points, options), options);
}

ModelsEstimate<Eigen::Vector4d> EstimatePlanes(const Eigen::Matrix<double, Eigen::Dynamic, 3>& points,
                                               const PointOptions& options) {
  return Several<Eigen::Vector4d>(ProblemOf(Task::kPlane, points, options), options);
}

}  // namespace diffsac
