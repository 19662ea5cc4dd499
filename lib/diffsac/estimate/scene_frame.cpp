#include "diffsac/estimate/scene_frame.h"

#include <cmath>

#include "diffsac/estimate/pixel_length.h"
#include "diffsac/geometry/absolute_pose.h"
#include "diffsac/geometry/motion_errors.h"
#include "diffsac/geometry/some_rows.h"

namespace diffsac {

SceneFrame::SceneFrame(const Points3DView& points) {
  constexpr double kFar = 16.0, kMostOctaves = 12.0;
  constexpr Eigen::Index kMost = 100'000;  // More say no more of where points are: some of them, evenly.
  Eigen::Vector3d middle, extent;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::VectorXd some = points.matrix()(SomeRows(points.rows(), kMost), axis);
    middle[axis] = Quantile(some, 0.5);
    extent[axis] = 2.0 * (Quantile(some, 0.75) - Quantile(some, 0.25));
  }
  const double longest = extent.maxCoeff();
  if (!(longest > 0.0)) return;
  if (middle.cwiseAbs().maxCoeff() > kFar * longest) origin = middle;
  const double octaves = std::round(std::log2(longest));
  if (std::abs(octaves) > kMostOctaves) unit = std::exp2(octaves);
}

SceneFrame::Points SceneFrame::Apply(const Points3DView& points) const {
  return (points.matrix().rowwise() - origin.transpose()) / unit;
}

/// Where a camera is has no unit but the scene's, and no origin.
void SceneFrame::Restore(Estimate* estimate) const {
  SceneFrame camera = *this;
  camera.origin.setZero();
  RestoreMotions(*this, camera, estimate);
}

void RestoreMotions(const SceneFrame& from, const SceneFrame& to, Estimate* estimate) {
  const auto is_own = [](const SceneFrame& frame) { return frame.unit == 1.0 && frame.origin.isZero(0.0); };
  if (estimate->status != Status::kOk || (is_own(from) && is_own(to))) return;
  const auto restored = [&](const Eigen::Matrix3d& turn, const Eigen::Vector3d& shift) -> Eigen::Vector3d {
    return to.unit * shift - turn * from.origin + to.origin;
  };
  const auto restored_model = [&](const ModelParameters& model) -> ModelParameters {
    const AbsolutePose::Parameters motion = model;
    const Eigen::Matrix3d turn = to.unit / from.unit * RotationOf(motion);
    return PoseOf(turn, restored(turn, TranslationOf(motion)));
  };
  estimate->model = restored_model(estimate->model);
  for (ModelParameters& model : estimate->instances) model = restored_model(model);
  if (estimate->pose) {
    const AbsolutePose::Parameters motion = estimate->model;
    const double scale = RotationOf(motion).col(0).norm();
    estimate->pose = RigidMotion{RotationOf(motion) / scale, TranslationOf(motion)};
  }
  if (auto& other = estimate->ambiguous_pose) other->translation = restored(other->rotation, other->translation);
  if (!estimate->pose_covariance) return;
  const Eigen::Vector3d lever = RotationOf(AbsolutePose::Parameters(estimate->model)) * from.origin;
  Eigen::MatrixXd change = ErrorsFromOrigin(lever, estimate->pose_covariance->rows());
  change.block<3, 3>(3, 3) *= to.unit;
  estimate->pose_covariance = change * *estimate->pose_covariance * change.transpose();
}

}  // namespace diffsac
