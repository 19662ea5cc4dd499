#include "diffsac/estimators/scene_frame.h"

#include <cmath>

#include "diffsac/estimators/pixel_length.h"
#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/rotation.h"

namespace diffsac {

SceneFrame::SceneFrame(const Points& points) {
  constexpr double kFar = 16.0, kMostOctaves = 12.0;
  Eigen::Vector3d middle, extent;
  for (int axis = 0; axis < 3; ++axis) {
    middle[axis] = Quantile(points.col(axis), 0.5);
    extent[axis] = 2.0 * (Quantile(points.col(axis), 0.75) - Quantile(points.col(axis), 0.25));
  }
  const double longest = extent.maxCoeff();
  if (!(longest > 0.0)) return;
  if (middle.cwiseAbs().maxCoeff() > kFar * longest) origin = middle;
  const double octaves = std::round(std::log2(longest));
  if (std::abs(octaves) > kMostOctaves) unit = std::exp2(octaves);
}

SceneFrame::Points SceneFrame::Apply(const Points& points) const {
  return (points.rowwise() - origin.transpose()) / unit;
}

void SceneFrame::Restore(Estimate* estimate) const {
  if (estimate->status != Status::kOk || (unit == 1.0 && origin.isZero(0.0))) return;
  const auto restored = [&](const ModelParameters& model) -> ModelParameters {
    const AbsolutePose::Parameters pose = model;
    const Eigen::Matrix3d rotation = RotationOf(pose);
    return PoseOf(rotation, unit * TranslationOf(pose) - rotation * origin);
  };
  if (estimate->pose_covariance) {
    // t is unit · t' − exp([ω]ₓ) R origin.
    const Eigen::Vector3d lever = RotationOf(AbsolutePose::Parameters(estimate->model)) * origin;
    Eigen::MatrixXd change = Eigen::MatrixXd::Identity(6, 6);
    change.block<3, 3>(3, 0) = CrossMatrix(lever);
    change.block<3, 3>(3, 3) *= unit;
    estimate->pose_covariance = change * *estimate->pose_covariance * change.transpose();
  }
  estimate->model = restored(estimate->model);
  for (ModelParameters& model : estimate->structures) model = restored(model);
  if (auto& other = estimate->other_pose) other->translation = unit * other->translation - other->rotation * origin;
}

}  // namespace diffsac
