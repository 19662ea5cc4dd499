#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "diffsac/core/random.h"
#include "diffsac/geometry/two_view.h"
#include "lab/truth/example.h"

namespace diffsac {

/// The best homography of 500 sets of four of these matches by MSAC at `threshold_px`, with local optimisation and
/// Levenberg-Marquardt; empty where fewer than `fewest` matches follow it.
std::optional<Matrix3Parameters> FitDominantPlane(const PointMatrix& points, double threshold_px, int fewest,
                                                  const Rng& rng);

/// The homography that most of the true matches of a pair follow, for pairs whose truth is a pose or a fundamental
/// matrix (KITTI, where the paper trains and tests homographies and does not say with which truth): that of
/// FitDominantPlane on the matches within `threshold_px` of the true F. Depends on the matches and on `id` alone. Empty
/// where fewer than 16 matches follow it, or the truth is unknown.
std::optional<Eigen::Matrix3d> DominantHomography(const Problem& problem, const GroundTruth& truth, double threshold_px,
                                                  const std::string& id);

}  // namespace diffsac
