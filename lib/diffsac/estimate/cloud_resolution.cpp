#include "diffsac/estimate/cloud_resolution.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace diffsac {
namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr double kNone = std::numeric_limits<double>::infinity();
/// A radius within which points are one place: others are so many times as far for half of the places.
constexpr double kApart = 4.0;
/// There are so many places at least, and so large a share of the points.
constexpr double kLeastPlaces = 8.0, kLeastShare = 0.1;
/// Distances to work out; of so many points at least, however many there are.
constexpr std::size_t kDistances = 1 << 19, kLeastAsked = 64;

/// Squared distances by size, two classes an octave, of points in a cube of side 1: of floating-point numbers the
/// exponent and the first digit.
constexpr int kShift = 51, kOctaves = 64, kClasses = 2 * (kOctaves + 2);
constexpr std::int64_t kLowest = 2 * (1023 - kOctaves);

int ClassOf(double square) {
  const std::int64_t place = (std::bit_cast<std::int64_t>(square) >> kShift) - kLowest;
  return static_cast<int>(std::clamp<std::int64_t>(place, 0, kClasses - 1));
}

/// The radius that holds the squares of a class and of those below.
double RadiusOf(int square_class) { return std::sqrt(std::bit_cast<double>((square_class + 1 + kLowest) << kShift)); }

/// The finite rows, each once, in an order of their own, moved and shrunk to a cube of side 1; and the side it was.
std::pair<Points, double> DistinctPoints(const Points3DView& cloud) {
  Points points;
  for (Eigen::Index i = 0; i < cloud.rows(); ++i)
    if (const Eigen::Vector3d point = cloud.matrix().row(i); point.allFinite()) points.push_back(point);
  if (points.empty()) return {points, 0.0};
  Eigen::Vector3d low = points[0], high = points[0];
  for (const Eigen::Vector3d& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const double side = (high - low).maxCoeff();
  if (!(side > 0.0 && std::isfinite(side))) return {{}, 0.0};
  const auto before = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  for (Eigen::Vector3d& point : points) point = (point - low) / side;
  return {points, side};
}

/// Of some of the points, by radius: how many points are within it, and how far the nearest beyond is.
struct Neighbours {
  Eigen::MatrixXf within, beyond;  ///< Classes × points that were asked.

  explicit Neighbours(const Points& points) {
    const std::size_t count = std::min(points.size(), std::max(kLeastAsked, kDistances / points.size()));
    within.setZero(kClasses, static_cast<Eigen::Index>(count));
    beyond.setConstant(kClasses, within.cols(), std::numeric_limits<float>::infinity());
    for (std::size_t k = 0; k < count; ++k)
      Ask(points, points[k * points.size() / count], static_cast<Eigen::Index>(k));
  }

 private:
  void Ask(const Points& points, const Eigen::Vector3d& asked, Eigen::Index k) {
    std::vector<double> least(kClasses + 1, kNone);
    for (const Eigen::Vector3d& point : points) {
      const double square = (point - asked).squaredNorm();
      const int square_class = ClassOf(square);
      within(square_class, k) += 1.0F;
      least[square_class] = std::min(least[square_class], square);
    }
    std::partial_sum(within.col(k).begin(), within.col(k).end(), within.col(k).begin());
    for (int c = kClasses - 1; c >= 0; --c) {
      beyond(c, k) = static_cast<float>(std::sqrt(least[c + 1]));
      least[c] = std::min(least[c], least[c + 1]);
    }
  }
};

/// The greatest radius that makes places of the points, as a class; 0 where none does. A point counts as its share of
/// its place.
int ClassOfPlaces(const Neighbours& neighbours, std::size_t points) {
  const double each = static_cast<double>(points) / static_cast<double>(neighbours.within.cols());
  for (int c = kClasses - 1; c > 0; --c) {
    const Eigen::ArrayXf shares = neighbours.within.row(c).array().inverse();
    const auto apart = (neighbours.beyond.row(c).array().transpose() >= static_cast<float>(kApart * RadiusOf(c)));
    const double places = shares.sum(), far = (apart.cast<float>() * shares).sum();
    if (each * places >= std::max(kLeastPlaces, kLeastShare * static_cast<double>(points)) && far >= 0.5 * places)
      return c;
  }
  return 0;
}

}  // namespace

double CloudResolution(const Points3DView& cloud) {
  const auto& [points, side] = DistinctPoints(cloud);
  if (points.size() < 2) return 0.0;
  const Neighbours neighbours(points);
  const int chosen = ClassOfPlaces(neighbours, points.size());
  std::vector<std::pair<float, double>> places;  // The nearest other place, and the share.
  double half = 0.0;
  for (Eigen::Index k = 0; k < neighbours.within.cols(); ++k) {
    places.emplace_back(neighbours.beyond(chosen, k), 1.0 / neighbours.within(chosen, k));
    half += 0.5 * places.back().second;
  }
  std::sort(places.begin(), places.end());
  for (const auto& [distance, share] : places)
    if ((half -= share) <= 1e-9) return std::isfinite(distance) ? side * distance : 0.0;
  return 0.0;
}

}  // namespace diffsac
