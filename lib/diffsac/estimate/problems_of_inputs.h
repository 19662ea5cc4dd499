#pragma once

#include "diffsac/correspondences.h"
#include "diffsac/estimate/estimate_options.h"
#include "diffsac/estimate/scene_frame.h"
#include "diffsac/options.h"
#include "diffsac/problem/problem.h"

namespace diffsac {

// The arguments of the functions in diffsac.h, checked, as problems. Throws Error, which names the argument.

/// The fields that all options have, checked.
template <class Options>
EstimateOptions SharedOptions(const Options& options) {
  EstimateOptions shared;
  shared.max_iterations = options.max_iterations;
  if constexpr (requires { options.min_iterations; }) {
    shared.min_iterations = options.min_iterations;
    shared.confidence = options.confidence;
    shared.num_threads = options.num_threads;
  }
  if constexpr (requires { options.guidance; }) {
    shared.guidance = options.guidance;
    shared.models_folder = options.models_folder;
  }
  if constexpr (requires { options.cameras; }) shared.cameras = options.cameras;
  shared.seed = options.seed;
  shared.Check();
  return shared;
}

/// F, E without its cameras, or H.
Problem TwoViewProblem(Task task, const Matches& matches, const ImageOptions& options);
/// E or H.
Problem CalibratedProblem(Task task, const Matches& matches, const CameraPair& cameras, const ImageOptions& options);
/// One or two unknown focal lengths. K1: of task one_focal.
Problem FocalProblem(Task task, const Matches& matches, const FocalOptions& options, const Eigen::Matrix3d* K1 = {});
/// frame: that of the points.
Problem AbsolutePoseProblem(const Matches2D3D& matches, const SceneFrame& frame, const Eigen::Matrix3d& K,
                            const ImageOptions& options);

/// Each cloud in a frame of its own, of a rigid motion in one unit.
struct CloudFrames {
  SceneFrame from, to;
  CloudFrames(Task task, const Matches3D3D& matches);
};

Problem RegistrationProblem(Task task, const Matches3D3D& matches, const CloudFrames& frames,
                            const RegistrationOptions& options);
Problem LineProblem(const Points2DView& points, const PointOptions& options);
Problem PlaneProblem(const Points3DView& points, const PointOptions& options);

}  // namespace diffsac
