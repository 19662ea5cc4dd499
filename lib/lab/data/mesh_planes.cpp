#include "lab/data/mesh_planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace diffsac {
namespace {

constexpr double kDistance = 0.002;
const double kCosine = std::cos(5.0 * std::numbers::pi / 180.0);
// Curved meshes have a plane for each triangle; so many of the largest are followed.
constexpr std::size_t kMostPlanes = 256;

// The plane of a triangle alone; false for one without area.
bool PlaneOf(const TriangleMesh& mesh, int triangle, MeshPlane* plane) {
  const auto& t = mesh.triangles[triangle];
  const Eigen::Vector3d& a = mesh.vertices[t[0]];
  const Eigen::Vector3d cross = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
  const double length = cross.norm();
  if (!(length > 1e-12)) return false;
  plane->normal = cross / length;
  plane->offset = -plane->normal.dot(a);
  return true;
}

bool Holds(const MeshPlane& plane, const TriangleMesh& mesh, int triangle, const Eigen::Vector3d& normal) {
  const auto& corners = mesh.triangles[triangle];
  return std::abs(plane.normal.dot(normal)) >= kCosine && std::all_of(corners.begin(), corners.end(), [&](int corner) {
           return std::abs(plane.normal.dot(mesh.vertices[corner]) + plane.offset) <= kDistance;
         });
}

}  // namespace

PlanarMesh::PlanarMesh(const std::string& path) : surface_(path) {
  const TriangleMesh& mesh = surface_.mesh();
  std::vector<int> order(mesh.triangles.size());
  std::vector<double> areas;
  for (int i = 0; i < static_cast<int>(order.size()); ++i) areas.push_back(surface_.AreaOf(i));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return areas[a] > areas[b]; });
  for (const int triangle : order) {
    MeshPlane own;
    if (!PlaneOf(mesh, triangle, &own)) continue;
    auto found = std::find_if(planes_.begin(), planes_.end(),
                              [&](const MeshPlane& plane) { return Holds(plane, mesh, triangle, own.normal); });
    if (found == planes_.end()) {
      if (planes_.size() == kMostPlanes) continue;
      planes_.push_back(std::move(own));
      found = planes_.end() - 1;
    }
    found->cumulative_area.push_back(found->area() + areas[triangle]);
    found->triangles.push_back(triangle);
  }
  std::erase_if(planes_, [&](const MeshPlane& plane) { return ShareOf(plane) < kLeastShare; });
  std::stable_sort(planes_.begin(), planes_.end(),
                   [](const MeshPlane& a, const MeshPlane& b) { return a.area() > b.area(); });
}

Eigen::Vector3d PlanarMesh::Sample(const MeshPlane& plane, Rng& rng) const {
  const auto& areas = plane.cumulative_area;
  const auto at = std::upper_bound(areas.begin(), areas.end() - 1, rng.Uniform() * areas.back());
  return surface_.SampleOn(plane.triangles[at - areas.begin()], rng);
}

}  // namespace diffsac
