#include "diffsac/problem/within_size.h"

#include <algorithm>
#include <cmath>

#include "diffsac/core/status.h"

namespace diffsac {
namespace {

struct Outside {
  Eigen::Index count = 0, finite = 0, first = -1;
  bool TooMany() const { return count > 2 && 20 * count > 3 * finite; }
};

Outside OutsideOf(const ImageSize& size, const Points2DView::Map& points) {
  const double margin = 2.0 + 0.02 * std::max(size.width, size.height);
  Outside outside;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double x = points(i, 0), y = points(i, 1);
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    outside.finite += 1;
    if (std::min(x, y) >= -margin && x <= size.width + margin && y <= size.height + margin) continue;
    if (outside.count++ == 0) outside.first = i;
  }
  return outside;
}

std::string Text(double x, double y) {
  return "(" + std::to_string(std::lround(x)) + ", " + std::to_string(std::lround(y)) + ")";
}

}  // namespace

void RequireWithin(const ImageSize& size, const Points2DView& view, const std::string& name) {
  if (!size.known()) return;
  const auto points = view.matrix();
  const Outside outside = OutsideOf(size, points);
  if (!outside.TooMany()) return;
  const ImageSize turned{size.height, size.width};
  throw Error(name + ": expected (width, height) of the image that the points are of, in their pixels, got " +
              Text(size.width, size.height) + ", but " + std::to_string(outside.count) + " of " +
              std::to_string(outside.finite) + " points are outside, first row " + std::to_string(outside.first) +
              " at " + Text(points(outside.first, 0), points(outside.first, 1)) +
              (OutsideOf(turned, points).TooMany() ? "" : "; " + Text(turned.width, turned.height) + " holds them"));
}

}  // namespace diffsac
