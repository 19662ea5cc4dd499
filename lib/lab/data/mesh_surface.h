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
  /// Of all triangles.
  double area() const { return cumulative_area_.back(); }
  double AreaOf(int triangle) const;
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
