#include "diffsac/estimate/problems_of_inputs.h"

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <utility>

#include "diffsac/estimate/cloud_resolution.h"
#include "diffsac/estimate/pixel_length.h"
#include "diffsac/estimate/require.h"
#include "diffsac/geometry/calibration.h"
#include "diffsac/problem/keypoint_similarity.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/problem/within_size.h"

namespace diffsac {
namespace {

void RequireEqualRows(const char* name, Eigen::Index rows, const char* other, Eigen::Index expected) {
  Require(rows == expected, name,
          "as many rows as " + std::string(other) + ", " + std::to_string(expected) + ", got " + std::to_string(rows));
}

void RequireOneEach(Eigen::Index rows, Eigen::Index points, const char* name) {
  Require(rows == 0 || rows == points, name,
          "one for each of " + std::to_string(points) + " points, or none, got " + std::to_string(rows));
}

/// Non-finite points, which are dropped, may have any values.
void RequireShares(const ValuesView& values, const PointMatrix& points, const char* name, const char* what) {
  constexpr double kMost = 1.0 + 1e-6;  // Rounded from single precision.
  RequireOneEach(values.rows(), points.rows(), name);
  const auto all = values.matrix();
  for (Eigen::Index i = 0; i < all.size(); ++i)
    if (!(all[i] >= 0.0 && all[i] <= kMost) && points.row(i).allFinite())
      throw Error(std::string(name) + ": expected " + what + ", got " + std::to_string(all[i]) + " in row " +
                  std::to_string(i));
}

/// `input`: Matches, Matches2D3D or Matches3D3D.
template <class Input>
void SetRatiosOrScores(const Input& input, Problem* problem) {
  problem->scored = !input.scores.empty();
  Require(!problem->scored || input.snn_ratio.empty(), "scores", "none beside snn_ratio: one of them");
  RequireShares(input.snn_ratio, problem->points, "snn_ratio",
                "the nearest distance over the second-nearest, from 0 to 1, lower is better");
  RequireShares(input.scores, problem->points, "scores", "a matcher's confidences, from 0 to 1, higher is better");
  problem->snn_ratio = input.snn_ratio.matrix();
  if (problem->scored) problem->snn_ratio = (1.0 - input.scores.matrix().array()).max(0.0);
}

void SetKeypointChanges(const Points2DView& changes, Problem* problem) {
  RequireOneEach(changes.rows(), problem->points.rows(), "scale_rotation_changes");
  problem->scale_rotation_changes = changes.matrix();
  for (Eigen::Index i = 0; i < changes.rows(); ++i) {
    auto row = problem->scale_rotation_changes.row(i);
    Require(row.allFinite() || !problem->points.row(i).allFinite(), "scale_rotation_changes", "finite values");
    row = SimilarityOf({0.0, 0.0}, row);
  }
}

ImageSize CheckedSize(const ImageSize& size, const Points2DView& points, const char* name) {
  Require(size.known() || size == ImageSize{}, name, "width and height in pixels, above 0, or neither");
  RequireWithin(size, points, name);
  return size;
}

/// The threshold that was asked for; nothing for the default.
std::optional<double> CheckedResidual(const std::optional<double>& max_residual) {
  Require(!max_residual || (*max_residual > 0.0 && std::isfinite(*max_residual)), "max_residual",
          "a number above 0, in the unit of the points");
  return max_residual;
}

/// The model that was given, row by row, in the shape of the result's.
ModelParameters CheckedModel(const Eigen::MatrixXd& model, Eigen::Index rows, Eigen::Index columns) {
  Require(model.rows() == rows && model.cols() == columns && model.allFinite() && model.norm() > 0.0, "initial_model",
          std::to_string(rows) + " x " + std::to_string(columns) + " finite numbers that are not all 0");
  return PointMatrix(model).reshaped<Eigen::RowMajor>();
}

std::optional<ModelParameters> CheckedMatrix(const std::optional<Eigen::MatrixXd>& model) {
  if (!model) return std::nullopt;
  return CheckedModel(*model, 3, 3).normalized();
}

/// [s R | t] between the frames.
std::optional<ModelParameters> MotionInFrames(const std::optional<Eigen::MatrixXd>& model, const SceneFrame& from,
                                              const SceneFrame& to) {
  if (!model) return std::nullopt;
  CheckedModel(*model, 3, 4);
  Eigen::MatrixXd moved = *model;
  moved.leftCols(3) *= from.unit / to.unit;
  moved.col(3) = (model->col(3) + model->leftCols(3) * from.origin - to.origin) / to.unit;
  return CheckedModel(moved, 3, 4);
}

/// What was asked for, or what is usual, in the unit of the matches.
double ResidualOf(Task task, const Matches& matches, const std::optional<double>& max_residual) {
  if (CheckedResidual(max_residual)) return *max_residual;
  return DefaultThreshold(task) * LengthInResiduals(task, matches.points1, matches.points2, PixelLength);
}

Problem ProblemOf(Task task, const Matches& matches, const std::optional<double>& max_residual) {
  RequireEqualRows("points2", matches.points2.rows(), "points1", matches.points1.rows());
  Problem problem;
  problem.task = task;
  problem.points.resize(matches.points1.rows(), 4);
  problem.points << matches.points1.matrix(), matches.points2.matrix();
  SetRatiosOrScores(matches, &problem);
  SetKeypointChanges(matches.scale_rotation_changes, &problem);
  problem.size1 = CheckedSize(matches.size1, matches.points1, "size1");
  problem.size2 = CheckedSize(matches.size2, matches.points2, "size2");
  problem.inlier_threshold = ResidualOf(task, matches, max_residual);
  problem.threshold_is_default = !max_residual;
  return problem;
}

/// A matrix of other points: pixels with the matrix of normalised coordinates, or an inverse, see all to the side.
void RequireInView(const Eigen::Matrix3d& K, const Points2DView& points, const char* name) {
  constexpr double kMostAside = 20.0;  // The tangent of 87 degrees.
  const Eigen::Matrix3d inverse = K.inverse();
  const Eigen::VectorXd aside =
      ((inverse.topLeftCorner<2, 2>() * points.matrix().transpose()).colwise() + inverse.topRightCorner<2, 1>())
          .colwise()
          .norm();
  if (Quantile(aside, 0.5) > kMostAside)
    throw Error(std::string(name) +
                ": expected the calibration matrix of these points, but it sees most of them at more than 87 degrees "
                "from its axis: it is in another unit, or inverted");
}

void CheckPrior(const char* name, const std::optional<FocalPrior>& prior) {
  if (!prior) return;
  Require(prior->focal > 0.0 && std::isfinite(prior->focal), std::string(name) + ".focal", "pixels, above 0");
  Require(prior->log_sigma > 0.0 && std::isfinite(prior->log_sigma), std::string(name) + ".log_sigma",
          "a standard deviation of log f, above 0");
}

/// No lens is as short or as long.
void RequireOfCamera(const std::optional<FocalPrior>& prior, const ImageSize& size, const std::string& name) {
  constexpr double kLeast = 0.1, kMost = 100.0;
  if (!prior || !size.known()) return;
  const double longer = std::max(size.width, size.height), share = prior->focal / longer;
  Require(share >= kLeast && share <= kMost, name + ".focal",
          "pixels, from " + std::to_string(kLeast * longer) + " to " + std::to_string(kMost * longer) +
              " of an image of this size");
}

/// options: of F or unknown focal lengths.
template <class Options>
void SetFocalPriors(const Options& options, Problem* problem) {
  CheckPrior("prior", options.prior);
  CheckPrior("prior2", options.prior2);
  problem->camera_prior1.focal = options.prior;
  problem->camera_prior2.focal = options.prior2 ? options.prior2 : options.prior;
  RequireOfCamera(problem->camera_prior1.focal, problem->size1, "prior");
  RequireOfCamera(problem->camera_prior2.focal, problem->size2, options.prior2 ? "prior2" : "prior");
}

template <int kColumns>
Problem PointsProblem(Task task, const RowsView<kColumns>& points, const PointOptions& options) {
  Require(options.max_residual.has_value(), "max_residual", "a distance: there is no default");
  Problem problem;
  problem.task = task;
  problem.inlier_threshold = *CheckedResidual(options.max_residual);
  problem.points = points.matrix();
  if (options.initial_model) {
    const ModelParameters model = CheckedModel(*options.initial_model, kColumns + 1, 1);
    Require(!model.head(kColumns).isZero(0.0), "initial_model", "a normal that is not 0");
    problem.initial_model = model / model.head(kColumns).norm();
  }
  return problem;
}

}  // namespace

Problem TwoViewProblem(Task task, const Matches& matches, const ImageOptions& options) {
  Problem problem = ProblemOf(task, matches, options.max_residual);
  problem.initial_model = CheckedMatrix(options.initial_model);
  SetFocalPriors(options, &problem);
  return problem;
}

Problem CalibratedProblem(Task task, const Matches& matches, const CameraPair& cameras, const ImageOptions& options) {
  Problem problem = TwoViewProblem(task, matches, options);
  problem.cameras = CameraPair{CheckedCalibration(cameras.K1, "K1"), CheckedCalibration(cameras.K2, "K2")};
  RequireInView(problem.cameras->K1, matches.points1, "K1");
  RequireInView(problem.cameras->K2, matches.points2, "K2");
  return problem;
}

Problem FocalProblem(Task task, const Matches& matches, const FocalOptions& options, const Eigen::Matrix3d* K1) {
  Require(!options.principal_point1 || options.principal_point1->allFinite(), "principal_point1", "finite pixels");
  Require(!options.principal_point2 || options.principal_point2->allFinite(), "principal_point2", "finite pixels");
  Problem problem = ProblemOf(task, matches, options.max_residual);
  problem.camera_prior1.principal_point = options.principal_point1;
  problem.camera_prior2.principal_point = options.principal_point2;
  SetFocalPriors(options, &problem);
  if (K1 != nullptr) problem.camera_prior1.K = CheckedCalibration(*K1, "K1");
  // K1 says all of the first image.
  Require(K1 != nullptr || options.principal_point1.has_value() || problem.size1.known(), "size1",
          "the image's size, or principal_point1");
  Require(options.principal_point2.has_value() || problem.size2.known(), "size2",
          "the image's size, or principal_point2");
  Require(options.prior.has_value() || ((K1 != nullptr || problem.size1.known()) && problem.size2.known()), "prior",
          "a focal length, or the images' sizes");
  return problem;
}

Problem AbsolutePoseProblem(const Matches2D3D& matches, const SceneFrame& frame, const Eigen::Matrix3d& K,
                            const ImageOptions& options) {
  RequireEqualRows("points2d", matches.points2d.rows(), "points3d", matches.points3d.rows());
  Problem problem;
  problem.task = Task::kAbsolutePose;
  problem.inlier_threshold =
      CheckedResidual(options.max_residual).value_or(DefaultThreshold(problem.task) * PixelLength(matches.points2d));
  problem.points.resize(matches.points3d.rows(), 5);
  problem.points << frame.Apply(matches.points3d), matches.points2d.matrix();
  SetRatiosOrScores(matches, &problem);
  const Eigen::Matrix3d checked = CheckedCalibration(K, "K");
  problem.cameras = CameraPair{checked, checked};
  SceneFrame camera = frame;
  camera.origin.setZero();
  problem.initial_model = MotionInFrames(options.initial_model, frame, camera);
  return problem;
}

CloudFrames::CloudFrames(Task task, const Matches3D3D& matches) : from(matches.points1), to(matches.points2) {
  if (task == Task::kRigid) from.unit = to.unit;
}

Problem RegistrationProblem(Task task, const Matches3D3D& matches, const CloudFrames& frames,
                            const RegistrationOptions& options) {
  constexpr double kResolutions = 2.0;
  RequireEqualRows("points2", matches.points2.rows(), "points1", matches.points1.rows());
  Problem problem;
  problem.task = task;
  problem.points.resize(matches.points1.rows(), 6);
  problem.points << frames.from.Apply(matches.points1), frames.to.Apply(matches.points2);
  const auto asked = CheckedResidual(options.max_residual);
  const double distance = asked ? *asked : kResolutions * CloudResolution(matches.points2);
  problem.inlier_threshold = distance > 0.0 ? distance / frames.to.unit : 1.0;
  SetRatiosOrScores(matches, &problem);
  problem.initial_model = MotionInFrames(options.initial_model, frames.from, frames.to);
  return problem;
}

Problem LineProblem(const Points2DView& points, const PointOptions& options) {
  return PointsProblem(Task::kLine, points, options);
}

Problem PlaneProblem(const Points3DView& points, const PointOptions& options) {
  return PointsProblem(Task::kPlane, points, options);
}

}  // namespace diffsac
