#pragma once

#include <array>

#include "diffsac/core/enum_names.h"
#include "diffsac/core/random.h"

namespace diffsac {

/// How a random model's offset is drawn once its direction is known.
enum class ModelSampling {
  kIsotropic,     ///< uniform among the offsets that meet the box
  kThroughPoint,  ///< through a point uniform in the box
};
template <>
inline constexpr auto kEnumNames<ModelSampling> =
    NamesOf<ModelSampling>({{ModelSampling::kIsotropic, "isotropic"}, {ModelSampling::kThroughPoint, "through_point"}});

/// The part of a random line inside the square [0, side]², from which points are drawn uniformly.
class LineSection {
 public:
  static constexpr int kDimension = 2;
  using Point = std::array<double, 2>;

  /// Uniform angle; uniform offset among those at which the line meets the square.
  static LineSection Random(double side, Rng& rng, ModelSampling sampling = ModelSampling::kIsotropic);

  const Point& normal() const { return normal_; }
  /// d of n · x + d = 0.
  double offset() const { return offset_; }
  /// Length of the chord; 0 when the line only touches a corner.
  double extent() const;
  /// Uniform on the chord.
  Point Sample(Rng& rng) const;

 private:
  Point normal_{};
  double offset_ = 0.0;
  Point start_{};
  Point end_{};
};

/// The part of a random plane inside the cube [0, side]³: a polygon of three to six corners.
class PlaneSection {
 public:
  static constexpr int kDimension = 3;
  using Point = std::array<double, 3>;

  /// Normal uniform on the sphere; uniform offset among those at which the plane meets the cube.
  static PlaneSection Random(double side, Rng& rng, ModelSampling sampling = ModelSampling::kIsotropic);

  const Point& normal() const { return normal_; }
  /// d of n · x + d = 0.
  double offset() const { return offset_; }
  /// Square root of the polygon's area.
  double extent() const;
  /// Uniform in the polygon: a triangle of the fan by its area, then a uniform point of the triangle.
  Point Sample(Rng& rng) const;

 private:
  Point normal_{};
  double offset_ = 0.0;
  std::array<Point, 6> corners_{};           // in order around the polygon
  std::array<double, 4> cumulative_area_{};  // of the fan's triangles (corner 0, i + 1, i + 2)
  int num_corners_ = 0;
};

}  // namespace diffsac
