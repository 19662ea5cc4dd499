#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "diffsac/core/random.h"

namespace diffsac {

/// A surface of triangles.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

/// Reads an OFF file (Object File Format, text): the word OFF, the numbers of vertices, faces and edges, a vertex a
/// line, a face a line (its number of corners, then their indices; colours behind them are skipped). Polygons become
/// fans of triangles. The numbers may be glued to the word ("OFF490 518 0", as in many files of ModelNet40); comments
/// (#), empty lines and lines that end in CR LF are fine.
///
/// Throws Error with file and line: something else than that, an index out of range, a value that is not finite, an
/// early end; and for a mesh without any area.
TriangleMesh ReadOff(const std::string& path);

/// The mesh moved and scaled into the unit sphere: the centre of its bounding box to the origin, the farthest vertex of
/// a triangle to distance 1.
TriangleMesh InUnitSphere(TriangleMesh mesh);

/// A mesh in the unit sphere, ready for drawing points uniform on its surface.
class MeshSurface {
 public:
  /// Reads an OFF file. Throws Error as ReadOff.
  explicit MeshSurface(const std::string& path);

  const TriangleMesh& mesh() const { return mesh_; }
  /// A triangle by its area, then a uniform point of it.
  Eigen::Vector3d Sample(Rng& rng, int* triangle) const;

 private:
  TriangleMesh mesh_;
  std::vector<double> cumulative_area_;
};

}  // namespace diffsac
