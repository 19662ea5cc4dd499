#pragma once

#include <optional>

#include "diffsac/geometry/rigid_motion.h"
#include "lab/ground_truth/estimate_error.h"
#include "lab/ground_truth/example.h"

namespace diffsac {

/// Adds the errors of the motion that a person is given (PoseOfEstimate of the estimate), whatever the model allows
/// beside it (docs/metrics.md#the-pose-that-is-given): of R, and of t with its sign, all of them kWorstPoseDeg without
/// a pose. A motion without t is wrong where the cameras are apart, and one with a t where they are in one place. Adds
/// nothing where no such motion can be judged: without a true pose, of other tasks than those of two views, and of F
/// and H without cameras.
void AddPoseError(const std::optional<RigidMotion>& pose, const Example& example, EstimateError* error);

}  // namespace diffsac
