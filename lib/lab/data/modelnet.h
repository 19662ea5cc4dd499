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

  /// Its keys stand beside the others. Defaults as in the paper where it names them: N = 200, outlier ratio 0.1 … 0.6,
  /// ε = 4 px; σ = 0.25 px, uniform outliers, no ratios.
  SyntheticMatchesOptions matches;
  // No keys from here on.

  /// 640 × 480, focal length 0.9 … 1.5 times the width, one camera for both views, principal point in the
  /// middle.
  VirtualCameraOptions cameras;

  /// Radius of the mesh in the image over half of the image's shorter side; decides the distance of the camera, which
  /// is 1.2 at least.
  Range fill = {0.7, 1.1};
  /// Angle between the two viewing directions.
  Range view_angle_deg = {5.0, 45.0};
  /// Each camera is turned about its axis by up to this, either way.
  double roll_deg = 15.0;
  /// Each camera looks at a point up to this far from the centre.
  double aim_offset = 0.1;
  /// A point is hidden when the depth buffer (one value a pixel) holds another triangle nearer by more than this.
  double depth_tolerance = 0.01;
  /// Meshes kept in memory.
  int cached_meshes = 64;

  /// `split` is of the random numbers; which meshes are used, `paths` and `subset` say.
  ModelnetOptions();
  void Bind(OptionsBinder& b);
};

/// Example i shows mesh i mod (number of meshes), in the order of the paths. Deterministic in (options, seed, index).
/// Truth: model, pose, inliers. Throws Error: no mesh found; from Get: a mesh that cannot be read, or of which no two
/// views show enough points.
std::unique_ptr<Dataset> MakeModelnet(const ModelnetOptions& options, std::uint64_t seed);

}  // namespace diffsac
