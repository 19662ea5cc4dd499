#include "lab/data/box_section.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace diffsac {
namespace {

template <std::size_t D>
using Point = std::array<double, D>;

template <std::size_t D>
double Dot(const Point<D>& a, const Point<D>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < D; ++i) sum += a[i] * b[i];
  return sum;
}

// The offset d, uniform among those at which n · x + d = 0 meets the box [0, side]^D.
template <std::size_t D>
double RandomOffset(const Point<D>& normal, double side, Rng& rng) {
  double low = 0.0, high = 0.0;
  for (double component : normal) (component < 0.0 ? low : high) += component * side;
  return -rng.Uniform(low, high);
}

// The offset of the model through a point uniform in the box: long sections are the likelier.
template <std::size_t D>
double OffsetThroughPoint(const Point<D>& normal, double side, Rng& rng) {
  Point<D> point;
  for (double& value : point) value = rng.Uniform(0.0, side);
  return -Dot(normal, point);
}

template <std::size_t D>
double DrawOffset(const Point<D>& normal, double side, ModelSampling sampling, Rng& rng) {
  return sampling == ModelSampling::kIsotropic ? RandomOffset(normal, side, rng)
                                               : OffsetThroughPoint(normal, side, rng);
}

Point<3> RandomUnitVector(Rng& rng) {
  for (;;) {
    const Point<3> v = {rng.Normal(), rng.Normal(), rng.Normal()};
    const double length = std::sqrt(Dot(v, v));
    if (length > 1e-6) return {v[0] / length, v[1] / length, v[2] / length};
  }
}

Point<3> Cross(const Point<3>& a, const Point<3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Point<3> Minus(const Point<3>& a, const Point<3>& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

double TriangleArea(const Point<3>& a, const Point<3>& b, const Point<3>& c) {
  const Point<3> cross = Cross(Minus(b, a), Minus(c, a));
  return 0.5 * std::sqrt(Dot(cross, cross));
}

// Where the plane crosses the 12 edges of the cube. A generic plane crosses at most six of them.
int EdgeCrossings(const Point<3>& normal, double offset, double side, std::array<Point<3>, 6>* out) {
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int edge = 0; edge < 4; ++edge) {
      Point<3> a{};
      a[(axis + 1) % 3] = (edge & 1) ? side : 0.0;
      a[(axis + 2) % 3] = (edge & 2) ? side : 0.0;
      Point<3> b = a;
      b[axis] = side;
      const double at_a = Dot(normal, a) + offset;
      const double at_b = Dot(normal, b) + offset;
      if ((at_a < 0.0) == (at_b < 0.0) || count == 6) continue;
      a[axis] = side * at_a / (at_a - at_b);
      (*out)[count++] = a;
    }
  }
  return count;
}

// Orders corners of a convex polygon by their angle around its centre.
void SortAround(const Point<3>& normal, int count, std::array<Point<3>, 6>* corners) {
  Point<3> centre{};
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < 3; ++k) centre[k] += (*corners)[i][k] / count;
  const Point<3> e1 = Minus((*corners)[0], centre);
  const Point<3> e2 = Cross(normal, e1);
  const auto angle = [&](const Point<3>& p) {
    const Point<3> q = Minus(p, centre);
    return std::atan2(Dot(q, e2), Dot(q, e1));
  };
  std::sort(corners->begin(), corners->begin() + count,
            [&](const Point<3>& a, const Point<3>& b) { return angle(a) < angle(b); });
}

}  // namespace

LineSection LineSection::Random(double side, Rng& rng, ModelSampling sampling) {
  LineSection section;
  const double angle = rng.Uniform(0.0, std::numbers::pi);
  section.normal_ = {std::cos(angle), std::sin(angle)};
  section.offset_ = DrawOffset(section.normal_, side, sampling, rng);
  const auto& n = section.normal_;
  const Point foot = {-section.offset_ * n[0], -section.offset_ * n[1]};
  const Point direction = {-n[1], n[0]};
  // Clip the line foot + t · direction by the square's two pairs of sides (Liang and Barsky, 1984).
  double from = -1e30, to = 1e30;
  for (int k = 0; k < 2; ++k) {
    if (direction[k] == 0.0) continue;
    const double a = -foot[k] / direction[k];
    const double b = (side - foot[k]) / direction[k];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  to = std::max(from, to);
  for (int k = 0; k < 2; ++k) {
    section.start_[k] = foot[k] + from * direction[k];
    section.end_[k] = foot[k] + to * direction[k];
  }
  return section;
}

double LineSection::extent() const { return std::hypot(end_[0] - start_[0], end_[1] - start_[1]); }

LineSection::Point LineSection::Sample(Rng& rng) const {
  const double t = rng.Uniform();
  return {start_[0] + t * (end_[0] - start_[0]), start_[1] + t * (end_[1] - start_[1])};
}

PlaneSection PlaneSection::Random(double side, Rng& rng, ModelSampling sampling) {
  PlaneSection section;
  section.normal_ = RandomUnitVector(rng);
  section.offset_ = DrawOffset(section.normal_, side, sampling, rng);
  section.num_corners_ = EdgeCrossings(section.normal_, section.offset_, side, &section.corners_);
  if (section.num_corners_ < 3) return section;
  SortAround(section.normal_, section.num_corners_, &section.corners_);
  double area = 0.0;
  for (int i = 0; i + 2 < section.num_corners_; ++i) {
    area += TriangleArea(section.corners_[0], section.corners_[i + 1], section.corners_[i + 2]);
    section.cumulative_area_[i] = area;
  }
  return section;
}

double PlaneSection::extent() const { return num_corners_ < 3 ? 0.0 : std::sqrt(cumulative_area_[num_corners_ - 3]); }

PlaneSection::Point PlaneSection::Sample(Rng& rng) const {
  const int triangles = num_corners_ - 2;
  const double pick = rng.Uniform() * cumulative_area_[triangles - 1];
  int i = 0;
  while (i + 1 < triangles && cumulative_area_[i] <= pick) ++i;
  // Folding the unit square over its diagonal makes a uniform point of the triangle.
  double s = rng.Uniform(), t = rng.Uniform();
  if (s + t > 1.0) s = 1.0 - s, t = 1.0 - t;
  Point p = corners_[0];
  for (int k = 0; k < 3; ++k)
    p[k] += s * (corners_[i + 1][k] - corners_[0][k]) + t * (corners_[i + 2][k] - corners_[0][k]);
  return p;
}

}  // namespace diffsac
