#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/problem/tasks.h"
#include "lab/data/synthetic_matches.h"
#include "lab/data/virtual_views.h"
#include "lab/options/options.h"

namespace diffsac {

/// Two virtual pinhole views of a mesh: correspondences are points of its surface that both see (the paper's ModelNet40
/// experiment, which names N and the outlier ratios; all else is fixed here). The unit of length is the radius of the
/// mesh, which is moved and scaled into the unit sphere (InUnitSphere).
struct ModelnetOptions : GeneratorOptions {
  std::vector<std::string> paths;
  std::string subset;
  Task task = Task::kFundamental;
  /// Its keys stand beside the others.
  SyntheticMatchesOptions matches;
  // No keys from here on; docs/generators.md has what they mean.
  VirtualCameraOptions cameras;
  Range fill = {0.7, 1.1};
  Range view_angle_deg = {5.0, 45.0};
  double roll_deg = 15.0, aim_offset = 0.1, depth_tolerance = 0.01;
  int cached_meshes = 64;
  ModelnetOptions();
  void Bind(OptionsBinder& b);
};

/// Example i shows mesh i mod (number of meshes), in the order of the paths. Deterministic in (options, seed, index).
/// Truth: model, pose, inliers. Throws Error: no mesh found; from Get: a mesh that cannot be read, or of which no two
/// views show enough points.
std::unique_ptr<Dataset> MakeModelnet(const ModelnetOptions& options, std::uint64_t seed);

}  // namespace diffsac
