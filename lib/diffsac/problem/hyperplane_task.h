#pragma once

#include "diffsac/geometry/hyperplane.h"
#include "diffsac/problem/chance_share.h"
#include "diffsac/problem/coordinates.h"
#include "diffsac/problem/task_description.h"

namespace diffsac {

/// Lines and planes, for what is made for them alone.
template <class Model>
concept HyperplaneModel = std::same_as<Model, Hyperplane<Model::kDimension>>;

template <>
inline constexpr const char* kModelName<Line> = "line";
template <>
inline constexpr const char* kModelName<Plane> = "plane";

/// Lines in the plane and planes in space.
template <HyperplaneModel M>
struct HyperplaneTask : TaskDescriptionOf<M> {
  static PointMatrix FeatureCoordinates(const NormalizedProblem& space) { return CentredCoordinates(space.points()); }
  static double ChanceShare(const Problem& problem, double threshold) { return SlabShare(problem.points, threshold); }
};

using LineTask = HyperplaneTask<Line>;
using PlaneTask = HyperplaneTask<Plane>;

}  // namespace diffsac
