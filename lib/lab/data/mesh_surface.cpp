#include "lab/data/mesh_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>
#include <utility>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

namespace fs = std::filesystem;

bool IsOff(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".off";
}

}  // namespace

MeshSurface::MeshSurface(const std::string& path) : mesh_(InUnitSphere(ReadOff(path))) {
  double area = 0.0;
  for (const auto& t : mesh_.triangles) {
    const Eigen::Vector3d& a = mesh_.vertices[t[0]];
    area += 0.5 * (mesh_.vertices[t[1]] - a).cross(mesh_.vertices[t[2]] - a).norm();
    cumulative_area_.push_back(area);
  }
}

double MeshSurface::AreaOf(int triangle) const {
  return cumulative_area_[triangle] - (triangle > 0 ? cumulative_area_[triangle - 1] : 0.0);
}

Eigen::Vector3d MeshSurface::Sample(Rng& rng, int* triangle) const {
  const double pick = rng.Uniform() * cumulative_area_.back();
  const auto at = std::upper_bound(cumulative_area_.begin(), cumulative_area_.end() - 1, pick);
  *triangle = static_cast<int>(at - cumulative_area_.begin());
  return SampleOn(*triangle, rng);
}

Eigen::Vector3d MeshSurface::SampleOn(int triangle, Rng& rng) const {
  double s = rng.Uniform(), t = rng.Uniform();
  if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
  const auto& corners = mesh_.triangles[triangle];
  const Eigen::Vector3d& a = mesh_.vertices[corners[0]];
  return a + s * (mesh_.vertices[corners[1]] - a) + t * (mesh_.vertices[corners[2]] - a);
}

std::vector<std::string> FindMeshes(const std::string& type, const std::vector<std::string>& paths,
                                    const std::string& subset) {
  std::vector<std::string> found;
  for (const std::string& path : paths) {
    std::error_code code;
    if (fs::is_regular_file(path, code)) {
      found.push_back(path);
      continue;
    }
    if (!fs::is_directory(path, code)) throw Error(path + ": no such file or folder");
    std::vector<std::string> below;
    for (const auto& entry : fs::recursive_directory_iterator(path))
      if (entry.is_regular_file() && IsOff(entry.path()) &&
          (subset.empty() || entry.path().parent_path().filename() == subset))
        below.push_back(entry.path().string());
    std::sort(below.begin(), below.end());
    found.insert(found.end(), below.begin(), below.end());
  }
  if (found.empty())
    throw Error(type + ": no OFF files in the given paths" + (subset.empty() ? "" : " (subset " + subset + ")"));
  return found;
}

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
