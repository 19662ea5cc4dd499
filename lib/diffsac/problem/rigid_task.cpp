#include "diffsac/problem/rigid_task.h"

#include "diffsac/problem/coordinates.h"

namespace diffsac {

template <bool kScaled>
PointMatrix CloudMotionTask<kScaled>::FeatureCoordinates(const NormalizedProblem& space) {
  PointMatrix coordinates(space.points().rows(), 6);
  coordinates << CentredCoordinates(space.points().leftCols(3)), CentredCoordinates(space.points().rightCols(3));
  return coordinates;
}

template <bool kScaled>
std::optional<RigidMotion> CloudMotionTask<kScaled>::Pose(const ModelParameters& model,
                                                          const std::vector<std::uint8_t>&, const NormalizedProblem&) {
  const Similarity::Parameters parameters = model;
  const double scale = kScaled ? ScaleOf(parameters) : 1.0;
  return RigidMotion{RotationOf(parameters) / scale, TranslationOf(parameters)};
}

template struct CloudMotionTask<false>;
template struct CloudMotionTask<true>;

}  // namespace diffsac
