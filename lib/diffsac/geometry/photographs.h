#pragma once

#include <Eigen/Core>
#include <array>

#include "diffsac/geometry/focal.h"
#include "diffsac/geometry/robust_loss.h"
#include "diffsac/geometry/unknown_focal.h"

namespace diffsac {

/// What is known of two photographs' cameras before any match is looked at, in the unit of points whose origins are the
/// images' middles.
struct PhotographPriors {
  FocalPriors focals;     ///< Log-normal.
  bool one_size = false;  ///< Both images have one size, so that their focal lengths are likely one.
};

/// Two photographs: E and the focal lengths in the unit of the points, and the principal points.
struct PhotographPair {
  FocalParameters model;
  Eigen::Vector4d principal_points = Eigen::Vector4d::Zero();  ///< Of the first image, then of the second.
};

/// F of points whose origins are the images' middles.
Matrix3Parameters FundamentalOf(const PhotographPair& pair);

/// Matches that a model was found for, in that unit, and what weighs a model of them.
struct NearMatches {
  Eigen::Matrix<double, Eigen::Dynamic, 4> points;
  Eigen::VectorXd weights;
  RobustLoss loss;
  double variance = 0.0;  ///< κ: the likelihood is exp(−cost / 2κ).

  int Count() const { return static_cast<int>(weights.size()); }
  std::array<const double*, 4> Columns() const {
    return {points.col(0).data(), points.col(1).data(), points.col(2).data(), points.col(3).data()};
  }
};

/// The pair of cameras that is likeliest by matches and priors, from *pair, by Levenberg-Marquardt over E, log f and
/// principal points (eleven dimensions). The latter, and the logarithm of the ratio of the lengths of images of one
/// size, have priors of heavy tails, so that a crop or a zoom costs little where matches speak of it. Returns −2κ log
/// of the posterior, less a constant; infinity, leaving *pair, where there is none.
double RefinePhotographs(const NearMatches& matches, const PhotographPriors& priors, PhotographPair* pair);

}  // namespace diffsac
