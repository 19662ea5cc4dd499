#include "lab/data/mesh_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <filesystem>
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

}  // namespace diffsac
