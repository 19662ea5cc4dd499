#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "diffsac/data/problem.h"

namespace diffsac {

/// The homography that most of the true matches of a pair follow, for pairs whose truth is a pose or a fundamental matrix
/// (KITTI, where the paper trains and tests homographies and does not say with which truth): the best of 500 sets of four
/// matches within `threshold_px` of the true F, by MSAC at `threshold_px`, with local optimisation and Levenberg-Marquardt.
/// Depends on the matches and on `id` alone. Empty where fewer than 16 matches follow it, or the truth is unknown.
std::optional<Eigen::Matrix3d> DominantHomography(const Problem& problem, const GroundTruth& truth,
                                                  double threshold_px, const std::string& id);

}  // namespace diffsac
