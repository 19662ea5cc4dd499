#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "diffsac/core/options.h"
#include "lab/data/generator.h"
#include "lab/truth/example.h"

namespace diffsac {

/// Task plane with several structures: points of a mesh whose large flat parts are the structures. The mesh is turned
/// at random and its sphere has a diameter of 10, as the cube of synthetic planes has sides. What is drawn, and how, is
/// in docs/generators.md.
struct ModelnetPlanesOptions : GeneratorOptions {
  std::vector<std::string> paths;  ///< OFF files, or folders that hold them at any depth.
  std::string subset;              ///< Only files in a folder of this name ("train", "test"); empty: all.
  Range num_points = {200, 200};
  Range outlier_ratio = {0.1, 0.5};
  double clutter_share = 0.5;     ///< Share of the outliers that lie on the rest of the mesh; the others are uniform.
  double inlier_threshold = 0.1;  ///< ε of the problem.
  double noise_scale = 0.0;       ///< σ of the gaussian noise along the normal; 0 means ε/3.
  /// Faces on one plane are a structure where they have at least this share of the mesh's area.
  double min_area_share = 0.05;
  int max_structures = 6;  ///< The largest ones.
  int cached_meshes = 64;  ///< Meshes kept in memory.
  /// `split` is of the random numbers; which meshes are used, `paths` and `subset` say.
  void Bind(OptionsBinder& b);
};

/// Example i shows mesh i mod (number of meshes), or the next one that has a structure. Deterministic in (options,
/// seed, index). Truth as MakeSyntheticStructures. Throws Error: no mesh found; from Get: a mesh that cannot be read,
/// or none that has a structure.
std::unique_ptr<Dataset> MakeModelnetPlanes(const ModelnetPlanesOptions& options, std::uint64_t seed);

}  // namespace diffsac
