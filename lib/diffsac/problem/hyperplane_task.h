#pragma once

#include "diffsac/geometry/hyperplane.h"
#include "diffsac/problem/chance_share.h"
#include "diffsac/problem/coordinates.h"
#include "diffsac/problem/hyperplane_labels.h"
#include "diffsac/problem/task_description.h"

namespace diffsac {

/// Lines and planes, for what is made for them alone.
template <class Model>
concept HyperplaneModel = std::same_as<Model, Hyperplane<Model::kDimension>>;

/// The angle between the normals and the difference of the offsets.
EstimateError HyperplaneError(const ModelParameters* model, const Example& example);

/// The points about their weighted mean, by their spread: v is the normal.
LinearEquations HyperplaneEquations(const PointMatrix& points, const GroundTruth& truth);

template <>
inline constexpr const char* kModelName<Line> = "line";
template <>
inline constexpr const char* kModelName<Plane> = "plane";

/// Lines in the plane and planes in space.
template <HyperplaneModel M>
struct HyperplaneTask : TaskDescriptionOf<M> {
  static PointMatrix FeatureCoordinates(const SolverSpace& space) { return CentredCoordinates(space.points()); }
  static std::vector<RankedSet> OptimalSets(const Example& example, const LabelOptions& options, int count) {
    return OptimalHyperplaneSets<M::kDimension>(example, options, count);
  }
  static EstimateError Error(const ModelParameters* model, const std::vector<std::uint8_t>&, const Example& example) {
    return HyperplaneError(model, example);
  }
  static double StructureAngle(const ModelParameters& a, const ModelParameters& b, const Example&) {
    return AngleBetweenDegrees(a, b);
  }
  static double ChanceShare(const Problem& problem, double threshold) { return SlabShare(problem.points, threshold); }
  static LinearEquations Equations(const SolverSpace& space, const GroundTruth& truth) {
    return HyperplaneEquations(space.points(), truth);
  }
};

using LineTask = HyperplaneTask<Line>;
using PlaneTask = HyperplaneTask<Plane>;

}  // namespace diffsac
