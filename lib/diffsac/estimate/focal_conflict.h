#pragma once

#include <optional>

#include "diffsac/estimate/robust_estimator.h"
#include "diffsac/problem/normalized_problem.h"

namespace diffsac {

/// Whether the matches contradict what was said of the focal lengths of an estimate that has a model: of E, the ones of
/// its calibrations, by a common factor; of unknown ones their prior, that of cameras in general too, and that there is
/// one of them. E and the lengths are fitted again with nothing known of these, from the model on, to more and more
/// matches: there is a conflict where that explains the matches far better than the model does, by lengths that are far
/// from what was said, beside what the matches and the prior leave open. Matches near a plane, and a motion straight
/// ahead, leave the more open.
///
/// Of right poses of real pairs with right calibrations .4 to 1.6 % have one (docs/two_view.md).
std::optional<FocalConflict> FindFocalConflict(const NormalizedProblem& solved, const Estimate& estimate);

/// Sets estimate->focal_conflict. Then no focal length is observable, its interval holds both values, and there is no
/// pose_covariance.
void TellFocalConflict(const NormalizedProblem& solved, Estimate* estimate);

}  // namespace diffsac
