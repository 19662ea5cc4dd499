#pragma once

#include <Eigen/Core>
#include <vector>

#include "diffsac/geometry/rigid_motion.h"
#include "lab/data/off_mesh.h"
#include "lab/data/virtual_views.h"

namespace diffsac {

/// What a camera sees of a mesh: for each pixel the nearest triangle through its centre and that one's depth.
class DepthBuffer {
 public:
  /// `pose` is world-to-camera; all of the mesh must lie before the camera. Triangles that hold no pixel's centre leave
  /// no trace.
  DepthBuffer(const TriangleMesh& mesh, const VirtualCamera& camera, const RigidMotion& pose);

  /// Whether a point of the surface, on the given triangle, is seen: inside the image, and its pixel shows this
  /// triangle, or nothing nearer than the point by more than `tolerance` (in the mesh's unit).
  bool Sees(const Eigen::Vector3d& point, int triangle, double tolerance) const;

  /// The nearest depth at a pixel; infinite where there is nothing.
  double DepthAt(int x, int y) const;

 private:
  struct Corner {
    Eigen::Vector2d pixel;
    double inverse_depth;  // not above 0: behind the camera
  };
  void Draw(const Corner& a, const Corner& b, const Corner& c, int triangle);

  VirtualCamera camera_;
  RigidMotion pose_;
  std::vector<double> inverse_depth_;  // 0: nothing
  std::vector<int> triangle_;
};

}  // namespace diffsac
