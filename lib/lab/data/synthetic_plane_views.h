#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "diffsac/core/options.h"
#include "lab/data/structure_sizes.h"
#include "lab/data/synthetic_matches.h"
#include "lab/data/virtual_views.h"
#include "lab/truth/example.h"

namespace diffsac {

/// Task homography with several structures: random scenes of K planes seen by two random cameras, each plane in its own
/// region of image 1. What is drawn, and how, is in docs/generators.md. The unit of length is the nearest depth of the
/// scene seen from camera 1.
struct SyntheticPlaneViewsOptions : GeneratorOptions {
  StructureOptions structures;      ///< Its keys stand beside the others.
  SyntheticMatchesOptions matches;  ///< Likewise.
  VirtualCameraOptions cameras;     ///< Likewise.
  /// Farthest over nearest depth of the points about which planes are, log-uniform; depths are log-uniform between.
  Range depth_ratio = {1.5, 8.0};
  /// Angle between a plane's normal and the first camera's axis.
  Range plane_tilt_deg = {0.0, 75.0};
  /// Distance of the cameras over the geometric mean of nearest and farthest depth, log-uniform.
  Range baseline = {0.05, 0.6};
  /// The second camera is turned by this about a random axis, after it was turned towards the middle of the scene with
  /// probability `converging`.
  Range rotation_deg = {0.0, 25.0};
  double converging = 0.5;
  /// Least share of a plane's region in image 1 that image 2 shows too.
  double min_overlap = 0.3;

  SyntheticPlaneViewsOptions();
  void Bind(OptionsBinder& b);
};

/// Deterministic in (options, seed, index). Truth: structures (homographies in pixels) and labels, largest first,
/// inliers of any of them, model and homography of the largest, relative pose. Throws Error for options that cannot be
/// met: with motions too small to tell planes apart, or too large to see them in both images.
std::unique_ptr<Dataset> MakeSyntheticPlaneViews(const SyntheticPlaneViewsOptions& options, std::uint64_t seed);

}  // namespace diffsac
