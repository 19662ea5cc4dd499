#include "diffsac/data/depth_buffer.h"

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
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) Draw(mesh, i);
}

void DepthBuffer::Draw(const TriangleMesh& mesh, int triangle) {
  Eigen::Vector2d corners[3];
  double inverse[3];
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d p = pose_.rotation * mesh.vertices[mesh.triangles[triangle][k]] + pose_.translation;
    if (!(p[2] > 0.0)) return;
    corners[k] = (camera_.K * p).hnormalized();
    inverse[k] = 1.0 / p[2];
  }
  const double area = Cross(corners[1] - corners[0], corners[2] - corners[0]);
  if (!(std::abs(area) > 1e-12)) return;
  const double low = std::min({corners[0][1], corners[1][1], corners[2][1]});
  const double high = std::max({corners[0][1], corners[1][1], corners[2][1]});
  // Pixel (x, y) has its centre at (x + ½, y + ½).
  const int last_row = static_cast<int>(std::floor(std::min(high - 0.5, camera_.size.height - 1.0)));
  for (int y = static_cast<int>(std::ceil(std::max(low - 0.5, 0.0))); y <= last_row; ++y) {
    // Along a row the barycentric coordinates, and with them 1 / depth, are linear: w(x) = at0 + slope · x.
    const Eigen::Vector2d start(0.5, y + 0.5);
    double from = 0.0, to = camera_.size.width - 1.0, at_start = 0.0, slope = 0.0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d &a = corners[(k + 1) % 3], &b = corners[(k + 2) % 3];
      const double w = Cross(a - start, b - start) / area, dw = (a[1] - b[1]) / area;
      if (dw > 0.0) from = std::max(from, -w / dw);
      if (dw < 0.0) to = std::min(to, -w / dw);
      if (dw == 0.0 && w < 0.0) to = -1.0;
      at_start += w * inverse[k];
      slope += dw * inverse[k];
    }
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
