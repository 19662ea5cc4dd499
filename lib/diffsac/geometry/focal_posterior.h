#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "diffsac/geometry/focal.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/unknown_focal.h"

namespace diffsac {

/// Of the width of the prior: an interval wider than this share of it is the prior's.
inline constexpr double kNarrower = 0.5;
/// What lens distortion, principal points that are off and mismatches do to f is common to all matches of a pair: no
/// number of them makes it smaller. So the interval has the posterior's covariance with what the matches say, in a
/// deviation, times the first and no surer than the second, in log f; FloorOf it, of matches on a plane. Chosen on the
/// tuning scenes, where it holds the truth in 62 % (two lengths) and 72 % (one).
inline constexpr double kIntervalFactor = 2.0, kIntervalFloor = 0.05;

/// What the matches on a plane leave open those beside it say, so that the same errors move f the more.
inline double FloorOf(double plane_share) { return kIntervalFloor / std::max(1.0 - plane_share, 0.1); }

/// Of matches that say `information` of log f, beside a prior: what the interval takes them to say.
template <class Matrix>
Matrix IntervalInformation(const Matrix& information, double floor = kIntervalFloor) {
  const double factor = kIntervalFactor * kIntervalFactor;
  return information * (factor * Matrix::Identity() + floor * floor * information).inverse();
}

/// The posterior of log f, on a grid; of two unknown lengths on one of two dimensions. At each f of the grid E is
/// refined with f held, from its neighbour's; the log-likelihood there is −cost / 2κ (κ: 4 ResidualVariance), that of
/// the best E; the prior is added. E is not integrated out: its volume, in radians, shrinks with f⁻⁵, which says how
/// angles are measured and nothing of cameras, and where the motion does not show f (straight ahead) that would be all
/// that is said. The grid covers three of the prior's standard deviations either way, and is fine about the f that
/// suits the matches best. `loss` and `weights` are those by which the model was refined; points far from *model sit
/// out.
///
/// Where a homography explains nine tenths of the points (a plane, a pure rotation), E and f are open together, and
/// what noise and outliers say of f is no evidence: the posterior is the prior. Where it explains fewer the interval is
/// wider (FloorOf).
///
/// Sets *model to the median with E refined there, whatever its likelihood before: on the mean of many pairs its poses
/// are better than those of the mode, which may lie at one end of a wide interval, or without it. False, leaving
/// *model, for points that do not determine E, and where a prior says nothing (log_sigma not above 0). Where there is
/// one length, the second image's prior counts.
bool MarginaliseFocal(UnknownFocal unknown, const PointMatrix& points, const Eigen::VectorXd& weights,
                      const RobustLoss& loss, const FocalPriors& priors, FocalParameters* model, FocalPosteriors* out);

}  // namespace diffsac
