#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "lab/data/off_mesh.h"

namespace diffsac {

/// A mesh in the unit sphere (InUnitSphere), ready for drawing points uniform on its surface.
class MeshSurface {
 public:
  /// Reads an OFF file. Throws Error as ReadOff.
  explicit MeshSurface(const std::string& path);

  const TriangleMesh& mesh() const { return mesh_; }
  /// A triangle by its area, then a uniform point of it.
  Eigen::Vector3d Sample(Rng& rng, int* triangle) const;
  /// A uniform point of a triangle (the unit square folded over its diagonal).
  Eigen::Vector3d SampleOn(int triangle, Rng& rng) const;

 private:
  TriangleMesh mesh_;
  std::vector<double> cumulative_area_;
};

/// OFF files in the order of the paths: files as they stand, and those below folders in the order of their names, only
/// from folders named `subset` unless that is empty. Throws Error: a path that is not there; no file (naming `type`).
std::vector<std::string> FindMeshes(const std::string& type, const std::vector<std::string>& paths,
                                    const std::string& subset);

}  // namespace diffsac
