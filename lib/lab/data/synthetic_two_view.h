#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic_matches.h"
#include "lab/data/virtual_views.h"
#include "lab/options/options.h"

namespace diffsac {

/// Random scenes seen by two random cameras: an endless source of correspondences for training without images. What is
/// drawn, and how, is in docs/generators.md; every constant is here. The unit of length is the nearest depth of the
/// scene seen from camera 1.
struct SyntheticTwoViewOptions : GeneratorOptions {
  Task task = Task::kFundamental;
  SyntheticMatchesOptions matches;  ///< Its keys stand beside the others.
  VirtualCameraOptions cameras;     ///< Likewise.
  double general = 0.4, planar = 0.05, mixed = 0.35, forward = 0.2;
  // No keys from here on; docs/generators.md has what they mean.
  Range depth_ratio = {1.5, 20.0};
  Range plane_share = {0.4, 0.9};
  Range plane_tilt_deg = {0.0, 75.0};
  Range baseline = {0.02, 0.6};
  Range rotation_deg = {0.0, 25.0};
  double converging = 0.5;
  Range forward_cone_deg = {0.0, 10.0};
  Range forward_rotation_deg = {0.0, 5.0};
  double min_overlap = 0.3;
  void Bind(OptionsBinder& b);
};

/// Deterministic in (options, seed, index). Truth: model, pose, inliers. Throws Error for options that cannot be met.
std::unique_ptr<Dataset> MakeSyntheticTwoView(const SyntheticTwoViewOptions& options, std::uint64_t seed);

}  // namespace diffsac
