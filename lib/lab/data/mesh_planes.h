#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "diffsac/core/random.h"
#include "lab/data/mesh_surface.h"

namespace diffsac {

/// Faces of a mesh that lie on one plane, normal · x + offset = 0 with |normal| = 1, also where they are apart.
struct MeshPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0.0;
  std::vector<int> triangles;
  std::vector<double> cumulative_area;  ///< of the triangles

  double area() const { return cumulative_area.empty() ? 0.0 : cumulative_area.back(); }
};

/// A mesh in the unit sphere and its planes.
class PlanarMesh {
 public:
  /// Planes of a smaller share of the mesh's area are not found.
  static constexpr double kLeastShare = 0.02;

  /// Reads an OFF file. Throws Error as ReadOff. Triangles are taken from the largest to the smallest; one joins the
  /// first plane from which none of its corners is farther than 0.002 and its normal no more than 5°, or starts
  /// another.
  explicit PlanarMesh(const std::string& path);

  const MeshSurface& surface() const { return surface_; }
  /// From the largest to the smallest.
  const std::vector<MeshPlane>& planes() const { return planes_; }
  double ShareOf(const MeshPlane& plane) const { return plane.area() / surface_.area(); }
  /// A uniform point of the plane's faces.
  Eigen::Vector3d Sample(const MeshPlane& plane, Rng& rng) const;

 private:
  MeshSurface surface_;
  std::vector<MeshPlane> planes_;
};

}  // namespace diffsac
