#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "diffsac/core/random.h"
#include "diffsac/geometry/points.h"
#include "lab/data/box_section.h"
#include "lab/data/synthetic.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// Side of the square and of the cube in which synthetic lines and planes lie.
inline constexpr double kBoxSide = 10.0;

/// LineSection::Point or PlaneSection::Point.
template <class Section>
using PointOf = typename Section::Point;

/// A section of at least `min_extent`. Any value up to kBoxSide can be met.
template <class Section>
Section DrawSection(ModelSampling sampling, double min_extent, Rng& rng) {
  for (;;) {
    Section section = Section::Random(kBoxSide, rng, sampling);
    if (section.extent() > 0.0 && section.extent() >= min_extent) return section;
  }
}

/// Displacements along the normal: of standard deviation (gaussian) or half width (uniform) `scale`; 0 means ε/3 or ε.
class NoiseSource {
 public:
  NoiseSource(NoiseKind kind, double scale, double inlier_threshold, Rng rng)
      : gaussian_(kind == NoiseKind::kGaussian), rng_(rng) {
    const double standard = gaussian_ ? inlier_threshold / 3.0 : inlier_threshold;
    scale_ = scale > 0.0 ? scale : standard;
  }
  double Next() { return gaussian_ ? scale_ * rng_.Normal() : rng_.Uniform(-scale_, scale_); }

 private:
  bool gaussian_;
  double scale_ = 0.0;
  Rng rng_;
};

/// Uniform on the section, displaced along its normal.
template <class Section>
void AppendOnSection(const Section& section, int count, NoiseSource noise, Rng rng,
                     std::vector<PointOf<Section>>* points) {
  for (int i = 0; i < count; ++i) {
    PointOf<Section> p = section.Sample(rng);
    const double displacement = noise.Next();
    for (int k = 0; k < Section::kDimension; ++k) p[k] += displacement * section.normal()[k];
    points->push_back(p);
  }
}

/// Uniform in the box.
template <class Point>
void AppendUniform(int count, Rng rng, std::vector<Point>* points) {
  for (int i = 0; i < count; ++i) {
    Point p;
    for (double& value : p) value = rng.Uniform(0.0, kBoxSide);
    points->push_back(p);
  }
}

/// The points and their labels in a random order.
template <class Point>
void SetShuffled(const std::vector<Point>& points, const std::vector<std::int32_t>& labels, Rng rng, Example* example) {
  const auto count = static_cast<int>(points.size());
  example->problem.points.resize(count, static_cast<Eigen::Index>(Point().size()));
  for (const int from : rng.Permutation(count)) {
    const auto row = static_cast<Eigen::Index>(example->truth.assignment.size());
    for (std::size_t k = 0; k < Point().size(); ++k) example->problem.points(row, k) = points[from][k];
    example->truth.assignment.push_back(labels[from]);
  }
}

/// (n, d).
template <class Section>
ModelParameters ParametersOf(const Section& section) {
  ModelParameters model(Section::kDimension + 1);
  for (int k = 0; k < Section::kDimension; ++k) model[k] = section.normal()[k];
  model[Section::kDimension] = section.offset();
  return model;
}

}  // namespace diffsac
