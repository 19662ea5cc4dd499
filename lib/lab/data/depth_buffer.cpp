#include "lab/data/depth_buffer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace diffsac {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a[0] * b[1] - a[1] * b[0]; }

}  // namespace

DepthBuffer::DepthBuffer(const TriangleMesh& mesh, const VirtualCamera& camera, const RigidMotion& pose)
    : camera_(camera), pose_(pose) {
  const std::size_t pixels = static_cast<std::size_t>(camera.size.width) * camera.size.height;
  inverse_depth_.assign(pixels, 0.0);
  triangle_.assign(pixels, -1);
  std::vector<Corner> corners;
  corners.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const Eigen::Vector3d p = pose.rotation * vertex + pose.translation;
    corners.push_back({(camera.K * p).hnormalized(), 1.0 / p[2]});
  }
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    Draw(corners[a], corners[b], corners[c], i);
  }
}

void DepthBuffer::Draw(const Corner& a, const Corner& b, const Corner& c, int triangle) {
  if (!(a.inverse_depth > 0.0 && b.inverse_depth > 0.0 && c.inverse_depth > 0.0)) return;
  const Eigen::Vector2d corners[3] = {a.pixel, b.pixel, c.pixel};
  const double inverse[3] = {a.inverse_depth, b.inverse_depth, c.inverse_depth};
  const double area = Cross(corners[1] - corners[0], corners[2] - corners[0]);
  if (!(std::abs(area) > 1e-12)) return;
  // Pixel (x, y) has its centre at (x + ½, y + ½). Most triangles of a fine mesh hold none.
  const double left = std::min({corners[0][0], corners[1][0], corners[2][0]});
  const double right = std::max({corners[0][0], corners[1][0], corners[2][0]});
  if (std::ceil(left - 0.5) > std::floor(right - 0.5)) return;
  const double low = std::min({corners[0][1], corners[1][1], corners[2][1]});
  const double high = std::max({corners[0][1], corners[1][1], corners[2][1]});
  const int first_row = static_cast<int>(std::ceil(std::max(low - 0.5, 0.0)));
  const int last_row = static_cast<int>(std::floor(std::min(high - 0.5, camera_.size.height - 1.0)));
  // The barycentric coordinates, and with them 1 / depth, are linear in the image: w(x, y) = w + dx · x + dy · y.
  const double per_area = 1.0 / area;
  double w[3], dx[3], dy[3], bound[3], start = 0.0, slope = 0.0, down = 0.0;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector2d &p = corners[(k + 1) % 3], &q = corners[(k + 2) % 3];
    const Eigen::Vector2d first(0.5, 0.5);
    w[k] = Cross(p - first, q - first) * per_area;
    dx[k] = (p[1] - q[1]) * per_area;
    dy[k] = (q[0] - p[0]) * per_area;
    bound[k] = -1.0 / dx[k];
    start += w[k] * inverse[k];
    slope += dx[k] * inverse[k];
    down += dy[k] * inverse[k];
  }
  for (int y = first_row; y <= last_row; ++y) {
    double from = 0.0, to = camera_.size.width - 1.0;
    for (int k = 0; k < 3; ++k) {
      const double at = w[k] + dy[k] * y;
      if (dx[k] > 0.0) from = std::max(from, at * bound[k]);
      if (dx[k] < 0.0) to = std::min(to, at * bound[k]);
      if (dx[k] == 0.0 && at < 0.0) to = -1.0;
    }
    const double at_start = start + down * y;
    double* depths = inverse_depth_.data() + static_cast<std::size_t>(y) * camera_.size.width;
    int* triangles = triangle_.data() + static_cast<std::size_t>(y) * camera_.size.width;
    const int last = static_cast<int>(std::floor(to));
    for (int x = static_cast<int>(std::ceil(from)); x <= last; ++x) {
      const double here = at_start + slope * x;
      if (here <= depths[x]) continue;
      depths[x] = here;
      triangles[x] = triangle;
    }
  }
}

bool DepthBuffer::Sees(const Eigen::Vector3d& point, int triangle, double tolerance) const {
  const Eigen::Vector3d p = pose_.rotation * point + pose_.translation;
  if (!(p[2] > 0.0)) return false;
  const Eigen::Vector2d pixel = (camera_.K * p).hnormalized();
  if (!camera_.Contains(pixel)) return false;
  const int x = std::min(static_cast<int>(pixel[0]), camera_.size.width - 1);
  const int y = std::min(static_cast<int>(pixel[1]), camera_.size.height - 1);
  const std::size_t at = static_cast<std::size_t>(y) * camera_.size.width + x;
  return triangle_[at] == triangle || p[2] <= DepthAt(x, y) + tolerance;
}

double DepthBuffer::DepthAt(int x, int y) const {
  const double inverse = inverse_depth_[static_cast<std::size_t>(y) * camera_.size.width + x];
  return inverse > 0.0 ? 1.0 / inverse : std::numeric_limits<double>::infinity();
}

}  // namespace diffsac
