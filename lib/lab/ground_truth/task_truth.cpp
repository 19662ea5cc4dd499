#include "lab/ground_truth/task_truth.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "diffsac/geometry/homography_decomposition.h"
#include "diffsac/geometry/pose.h"
#include "diffsac/problem/tasks.h"
#include "diffsac/ransac/sample_consensus.h"

namespace diffsac {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

double OffsetDifference(const ModelParameters& a, const ModelParameters& b, const PointMatrix& points) {
  const Eigen::Index d = points.cols();
  const Eigen::VectorXd centroid = points.colwise().mean();
  const double side = a.head(d).dot(b.head(d)) < 0.0 ? -1.0 : 1.0;
  return std::abs(a.head(d).dot(centroid) + a[d] - side * (b.head(d).dot(centroid) + b[d]));
}

double BoundingDiagonal(const PointMatrix& points) {
  if (points.rows() == 0) return 0.0;
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
}

Eigen::Vector3d CentreOf(const AbsolutePose::Parameters& pose) {
  return -RotationOf(pose).transpose() * TranslationOf(pose);
}

/// The error of a direction in degrees, either sign; 0 where the true one is zero.
double TranslationErrorDegrees(const Eigen::Vector3d& estimate, const Eigen::Vector3d& truth) {
  if (truth.norm() == 0.0) return 0.0;
  const double angle = DirectionAngleDegrees(estimate, truth);
  return std::min(angle, 180.0 - angle);
}

/// With its sign; a t of zero says that there is none, which is right or wrong.
double SignedDirectionError(const Eigen::Vector3d& estimate, const Eigen::Vector3d& truth) {
  const bool told = estimate.norm() > 0.0, there = truth.norm() > 0.0;
  if (told && there) return DirectionAngleDegrees(estimate, truth);
  return told == there ? 0.0 : kWorstPoseDeg;
}

constexpr int kBoxGrid = 10;

/// Homogeneous pixels of image 1, whose true transfer is before the second camera where w has this sign.
double FrontSign(const Eigen::Matrix3d& truth, const Example& example) {
  const PointMatrix& points = example.problem.points;
  const auto& inliers = example.truth.inliers;
  const bool labelled = inliers.size() == static_cast<std::size_t>(points.rows());
  int balance = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    if (labelled && !inliers[i]) continue;
    const double w = truth.row(2).dot(Eigen::RowVector3d(points(i, 0), points(i, 1), 1.0));
    balance += w > 0.0 ? 1 : w < 0.0 ? -1 : 0;
  }
  return balance < 0 ? -1.0 : 1.0;
}

std::vector<Eigen::Vector2d> BoxGrid(const PointMatrix& points) {
  std::vector<Eigen::Vector2d> grid;
  if (points.rows() == 0) return grid;
  const Eigen::RowVectorXd low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  for (int i = 0; i < kBoxGrid; ++i)
    for (int j = 0; j < kBoxGrid; ++j)
      grid.emplace_back(low[0] + (high[0] - low[0]) * i / (kBoxGrid - 1),
                        low[1] + (high[1] - low[1]) * j / (kBoxGrid - 1));
  return grid;
}

/// The motions that leave the inliers before the camera, or all where none does.
PlaneMotions MotionsOf(const Eigen::Matrix3d& model, const std::vector<std::uint8_t>& inliers, const Problem& problem) {
  const auto& [K1, K2] = *problem.cameras;
  std::vector<int> rows;
  for (std::size_t i = 0; i < inliers.size(); ++i)
    if (inliers[i]) rows.push_back(static_cast<int>(i));
  const PlaneMotions motions = DecomposeHomography(model, K1, K2);
  const PlaneMotions visible = KeepVisible(motions, problem.points(rows, Eigen::all), K1);
  return visible.count > 0 ? visible : motions;
}

/// The least error among the motions: which of the mostly two is meant, one homography cannot tell.
void AddMotionError(const ModelParameters* model, const std::vector<std::uint8_t>& inliers, const Example& example,
                    EstimateError* error) {
  if (!example.truth.pose || !example.problem.cameras) return;
  error->rotation_deg = kWorstRotationDeg;
  error->translation_deg = kWorstTranslationDeg;
  PlaneMotions motions;
  if (model != nullptr) motions = MotionsOf(ModelMatrix(*model), inliers, example.problem);
  for (int i = 0; i < motions.count; ++i) {
    const double rotation = RotationAngleDegrees(motions.motions[i].rotation, example.truth.pose->rotation);
    const double translation = TranslationErrorDegrees(motions.motions[i].translation, example.truth.pose->translation);
    if (std::max(rotation, translation) >= std::max(error->rotation_deg, error->translation_deg)) continue;
    error->rotation_deg = rotation;
    error->translation_deg = translation;
  }
  error->angle_deg = std::max(error->rotation_deg, error->translation_deg);
}

/// The error of the pose that E chooses with the estimate's inliers by cheirality, E null for a failure. Both errors as
/// in the CVPR 2020 RANSAC tutorial: the translation's sign does not count, a pose that cannot be chosen (fewer than 5
/// inliers, none before both cameras) is a failure of 180° and 90°. Where the true translation is zero its error is 0.
EstimateError EpipolarPoseError(const Eigen::Matrix3d* essential, const CameraPair& cameras,
                                const std::vector<std::uint8_t>& inliers, const Example& example) {
  EstimateError error;
  error.rotation_deg = kWorstRotationDeg;
  error.translation_deg = kWorstTranslationDeg;
  std::optional<RigidMotion> pose;
  if (essential != nullptr)
    pose = EpipolarPose(*essential, NormalizedCoordinates(example.problem.points, cameras.K1, cameras.K2), inliers);
  error.failed = !pose;
  if (pose) {
    error.rotation_deg = RotationAngleDegrees(pose->rotation, example.truth.pose->rotation);
    error.translation_deg = TranslationErrorDegrees(pose->translation, example.truth.pose->translation);
  }
  error.angle_deg = std::max(error.rotation_deg, error.translation_deg);
  return error;
}

/// error_px: the mean Sampson distance of the true inliers to F, null for a failure; NaN where none are known.
EstimateError EpipolarInlierError(const Matrix3Parameters* fundamental, const Example& example) {
  EstimateError error;
  error.failed = fundamental == nullptr;
  const auto& inliers = example.truth.inliers;
  const auto count = std::count(inliers.begin(), inliers.end(), 1);
  if (count == 0) return error;
  error.error_px = std::numeric_limits<double>::infinity();
  if (error.failed) return error;
  double sum = 0.0;
  for (std::size_t i = 0; i < inliers.size(); ++i)
    if (inliers[i]) sum += SampsonError(*fundamental, example.problem.points.row(i).data());
  if (std::isfinite(sum)) error.error_px = sum / static_cast<double>(count);
  return error;
}

EstimateError HyperplaneError(const ModelParameters* model, const std::vector<std::uint8_t>&, const Example& example) {
  const ModelParameters& truth = example.truth.model;
  const PointMatrix& points = example.problem.points;
  EstimateError error;
  error.failed = model == nullptr;
  if (truth.size() == 0) return error;
  if (error.failed) {
    error.angle_deg = kWorstAngleDeg;
    error.offset = BoundingDiagonal(points);
  } else {
    error.angle_deg = AngleBetweenDegrees(*model, truth);
    error.offset = OffsetDifference(*model, truth, points);
  }
  return error;
}

EstimateError AbsolutePoseError(const ModelParameters* model, const std::vector<std::uint8_t>&,
                                const Example& example) {
  EstimateError error;
  error.failed = model == nullptr;
  if (example.truth.model.size() != AbsolutePose::Parameters::SizeAtCompileTime) return error;
  const AbsolutePose::Parameters truth = example.truth.model;
  error.rotation_deg = kWorstRotationDeg;
  error.translation_deg = kWorstTranslationDeg;
  error.offset = std::numeric_limits<double>::infinity();
  if (!error.failed) {
    const AbsolutePose::Parameters pose = *model;
    const Eigen::Vector3d middle = example.problem.points.leftCols(3).colwise().mean().transpose();
    error.rotation_deg = RotationAngleDegrees(RotationOf(pose), RotationOf(truth));
    error.offset = (CentreOf(pose) - CentreOf(truth)).norm();
    error.translation_deg = std::atan2(error.offset, (CentreOf(truth) - middle).norm()) * 180.0 / std::numbers::pi;
  }
  error.angle_deg = std::max(error.rotation_deg, error.translation_deg);
  return error;
}

/// Of the rotation, and of the second cloud's origin by GroundTruth::length_per_degree; a wrong scale moves it too.
EstimateError CloudMotionError(const ModelParameters* model, const std::vector<std::uint8_t>&, const Example& example) {
  EstimateError error;
  error.failed = model == nullptr;
  if (example.truth.model.size() != Rigid::Parameters::SizeAtCompileTime) return error;
  const Rigid::Parameters truth = example.truth.model;
  error.rotation_deg = error.translation_deg = kWorstRotationDeg;
  error.offset = std::numeric_limits<double>::infinity();
  if (!error.failed) {
    const Rigid::Parameters motion = *model;
    error.rotation_deg = RotationAngleDegrees(RotationOf(motion) / ScaleOf(motion), RotationOf(truth) / ScaleOf(truth));
    error.offset = (TranslationOf(motion) - TranslationOf(truth)).norm();
    error.translation_deg = std::min(kWorstRotationDeg, error.offset / example.truth.length_per_degree);
  }
  error.angle_deg = std::max(error.rotation_deg, error.translation_deg);
  return error;
}

double VanishingPointAngle(const ModelParameters& a, const ModelParameters& b, const Example& example) {
  const auto& cameras = example.truth.cameras ? example.truth.cameras : example.problem.cameras;
  Eigen::Matrix3d to_space = Eigen::Matrix3d::Identity();
  if (cameras) to_space = cameras->K1.inverse() * SegmentCamera(example.problem);
  const Eigen::Vector3d first = (to_space * Eigen::Vector3d(a)).normalized(),
                        second = (to_space * Eigen::Vector3d(b)).normalized();
  return std::atan2(first.cross(second).norm(), std::abs(first.dot(second))) * kDegrees;
}

EstimateError VanishingPointError(const ModelParameters* model, const std::vector<std::uint8_t>&,
                                  const Example& example) {
  EstimateError error;
  error.failed = model == nullptr;
  if (example.truth.model.size() != 3) return error;
  error.angle_deg = error.failed ? kWorstAngleDeg : VanishingPointAngle(*model, example.truth.model, example);
  return error;
}

/// Description: of fundamental or essential matrices.
template <class Description>
EstimateError EpipolarError(const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                            const Example& example) {
  const Problem& problem = example.problem;
  if (example.truth.pose && problem.cameras) {
    if (model == nullptr) return EpipolarPoseError(nullptr, *problem.cameras, inliers, example);
    const Eigen::Matrix3d essential = Description::EssentialOf(ModelMatrix(*model), *problem.cameras);
    return EpipolarPoseError(&essential, *problem.cameras, inliers, example);
  }
  if (model == nullptr) return EpipolarInlierError(nullptr, example);
  const Matrix3Parameters fundamental = Description::PixelModel(*model, problem);
  return EpipolarInlierError(&fundamental, example);
}
EstimateError FocalError(UnknownFocal unknown, const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                         const Example& example) {
  const Problem& problem = example.problem;
  std::optional<CameraPair> cameras;
  Eigen::Matrix3d essential;
  if (model != nullptr && FocalSpaceOf(unknown, problem)) {
    cameras = CamerasOfFocal(unknown, FocalParameters(*model), problem);
    essential = EssentialOfFocal(unknown, FocalParameters(*model), problem);
  }
  EstimateError error;
  if (example.truth.pose) {
    error = EpipolarPoseError(cameras ? &essential : nullptr, cameras.value_or(CameraPair{}), inliers, example);
  } else if (cameras) {
    const Matrix3Parameters f = AsParameters(FundamentalFromEssential(essential, cameras->K1, cameras->K2));
    error = EpipolarInlierError(&f, example);
  } else {
    error = EpipolarInlierError(nullptr, example);
  }
  if (!example.truth.cameras) return error;
  error.focal = std::numeric_limits<double>::infinity();
  if (!cameras) return error;
  const auto relative = [](const Eigen::Matrix3d& K, const Eigen::Matrix3d& truth) {
    return std::abs(FocalOf(K) / FocalOf(truth) - 1.0);
  };
  error.focal =
      std::max(relative(cameras->K1, example.truth.cameras->K1), relative(cameras->K2, example.truth.cameras->K2));
  return error;
}

/// In the coordinates of FocalTask.
ModelParameters TrueFocalModel(UnknownFocal unknown, const Problem& problem, const GroundTruth& truth) {
  const auto space = FocalSpaceOf(unknown, problem);
  if (!space || !truth.essential || !truth.cameras) return {};
  const Eigen::Matrix3d& essential = *truth.essential;
  const auto& [K1, K2] = *truth.cameras;
  const double focal1 = FocalOf(space->swapped ? K2 : K1) / space->unit[0],
               focal2 = FocalOf(space->swapped ? K1 : K2) / space->unit[1];
  const Eigen::Matrix3d placed = space->swapped ? Eigen::Matrix3d(essential.transpose()) : essential;
  return AsFocalParameters(AsParameters(placed), focal1, focal2);
}

template <UnknownFocal kUnknown>
ModelParameters TrueFocalModel(const Problem& problem, const GroundTruth& truth) {
  return TrueFocalModel(kUnknown, problem, truth);
}
template <UnknownFocal kUnknown>
EstimateError FocalError(const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                         const Example& example) {
  return FocalError(kUnknown, model, inliers, example);
}

template <std::optional<Eigen::Matrix3d> GroundTruth::*kMatrix>
ModelParameters TrueMatrix(const Problem&, const GroundTruth& truth) {
  if (const auto& matrix = truth.*kMatrix) return AsParameters(*matrix);
  return {};
}

double HyperplaneAngle(const ModelParameters& a, const ModelParameters& b, const Example&) {
  return AngleBetweenDegrees(a, b);
}

}  // namespace

const TaskTruth& TruthOf(Task task) {
  static const auto kTruths = [] {
    std::map<Task, TaskTruth> truths;
    TaskTruth& line = truths[Task::kLine];
    line.error = HyperplaneError;
    line.instance_angle = HyperplaneAngle;
    line.equations = HyperplaneEquations;
    line.optimal_sets = OptimalHyperplaneSets<2>;
    truths[Task::kPlane] = line;
    truths[Task::kPlane].optimal_sets = OptimalHyperplaneSets<3>;

    TaskTruth& homography = truths[Task::kHomography];
    homography.error = HomographyError;
    homography.error_in_pixels = true;
    homography.true_model = TrueMatrix<&GroundTruth::homography>;
    homography.equations = HomographyEquations;

    TaskTruth& fundamental = truths[Task::kFundamental];
    fundamental.error = EpipolarError<FundamentalTask>;
    fundamental.true_model = TrueMatrix<&GroundTruth::fundamental>;
    fundamental.equations = EpipolarEquations;

    TaskTruth& essential = truths[Task::kEssential];
    essential.error = EpipolarError<EssentialTask>;
    essential.true_model = TrueMatrix<&GroundTruth::essential>;
    essential.equations = EpipolarEquations;

    TaskTruth& shared_focal = truths[Task::kSharedFocal];
    shared_focal.error = FocalError<UnknownFocal::kBoth>;
    shared_focal.true_model = TrueFocalModel<UnknownFocal::kBoth>;
    TaskTruth& one_focal = truths[Task::kOneFocal];
    one_focal.error = FocalError<UnknownFocal::kSecond>;
    one_focal.true_model = TrueFocalModel<UnknownFocal::kSecond>;
    TaskTruth& two_focals = truths[Task::kTwoFocals];
    two_focals.error = FocalError<UnknownFocal::kEach>;
    two_focals.true_model = TrueFocalModel<UnknownFocal::kEach>;

    truths[Task::kAbsolutePose].error = AbsolutePoseError;
    truths[Task::kRigid].error = truths[Task::kSimilarity].error = CloudMotionError;
    TaskTruth& vanishing_point = truths[Task::kVanishingPoint];
    vanishing_point.error = VanishingPointError;
    vanishing_point.instance_angle = VanishingPointAngle;
    return truths;
  }();
  return kTruths.at(task);
}

bool ErrorInPixels(Task task) { return TruthOf(task).error_in_pixels; }

EstimateError HomographyError(const ModelParameters* model, const std::vector<std::uint8_t>& inliers,
                              const Example& example) {
  EstimateError error;
  error.failed = model == nullptr;
  AddMotionError(model, inliers, example, &error);
  if (example.truth.model.size() != 9) return error;
  error.error_px = std::numeric_limits<double>::infinity();
  if (error.failed) return error;
  const Eigen::Matrix3d found = ModelMatrix(*model), truth = ModelMatrix(example.truth.model);
  std::vector<Eigen::Vector2d> grid = JointlyVisiblePixels(example);
  if (grid.empty()) grid = BoxGrid(example.problem.points);
  if (grid.empty()) return error;
  double sum = 0.0;
  for (const Eigen::Vector2d& pixel : grid)
    sum += ((found * pixel.homogeneous()).hnormalized() - (truth * pixel.homogeneous()).hnormalized()).norm();
  if (std::isfinite(sum)) error.error_px = sum / static_cast<double>(grid.size());
  return error;
}

std::vector<Eigen::Vector2d> JointlyVisiblePixels(const Example& example) {
  std::vector<Eigen::Vector2d> pixels;
  const ImageSize &size1 = example.problem.size1, &size2 = example.problem.size2;
  if (!size1.known() || !size2.known() || example.truth.model.size() != 9) return pixels;
  const Eigen::Matrix3d truth = ModelMatrix(example.truth.model);
  const double front = FrontSign(truth, example);
  for (int y = kVisibleStep / 2; y < size1.height; y += kVisibleStep)
    for (int x = kVisibleStep / 2; x < size1.width; x += kVisibleStep) {
      const Eigen::Vector3d moved = truth * Eigen::Vector3d(x, y, 1.0);
      if (!(front * moved[2] > 0.0)) continue;
      const Eigen::Vector2d there = moved.hnormalized();
      if (there[0] >= 0.0 && there[0] <= size2.width - 1 && there[1] >= 0.0 && there[1] <= size2.height - 1)
        pixels.emplace_back(x, y);
    }
  return pixels;
}

std::vector<std::uint8_t> AbsolutePoseInliers(const Problem& problem, const AbsolutePose::Parameters& pose) {
  const NormalizedProblem space(problem);
  return InlierMask<AbsolutePose>(space.points(), pose, space.threshold());
}

void AddPoseError(const std::optional<RigidMotion>& pose, const Example& example, EstimateError* error) {
  const Problem& problem = example.problem;
  if (!IsTwoView(problem.task) || !example.truth.pose) return;
  if (!problem.cameras && !FindsFocals(problem.task)) return;
  error->pose_rotation_deg = error->pose_translation_deg = kWorstPoseDeg;
  if (pose && pose->rotation.allFinite() && pose->translation.allFinite()) {
    error->pose_rotation_deg = RotationAngleDegrees(pose->rotation, example.truth.pose->rotation);
    error->pose_translation_deg = SignedDirectionError(pose->translation, example.truth.pose->translation);
  }
  error->pose_deg = std::max(error->pose_rotation_deg, error->pose_translation_deg);
}

}  // namespace diffsac
