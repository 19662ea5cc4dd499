#pragma once

#include <array>

namespace diffsac {

/// What is known of a focal length before any match is looked at: log-normal. Its median, in the unit of the points
/// that it goes with, and the standard deviation of its logarithm (.1: about ten per cent).
struct FocalPrior {
  double focal = 0.0;      ///< The median.
  double log_sigma = 0.0;  ///< The standard deviation of its logarithm.
};

/// Of the focal lengths of two images; equal where they are one.
using FocalPriors = std::array<FocalPrior, 2>;

/// What matches and a prior say of a focal length, in the unit of the points.
struct FocalPosterior {
  double focal = 0.0;        ///< The median of the posterior of log f.
  double low = 0.0;          ///< Where its central 68 % begin, made wider (kIntervalFactor in focal_posterior.h).
  double high = 0.0;         ///< Where they end.
  bool observable = false;   ///< Whether the interval is narrower than the prior's (kNarrower).
  FocalPrior prior = {};     ///< What it started from.
  double correlation = 0.0;  ///< Of log f with that of the other image, in the interval's covariance.
};

/// Of either image; a calibrated one's is 1, observable, of a prior of width 0.
using FocalPosteriors = std::array<FocalPosterior, 2>;

/// What matches and prior say of the focal lengths of two images, each entry of one image. Equal lengths have equal
/// entries; a length that was given is its own interval, observable, and its own prior of width 0.
struct FocalEstimate {
  std::array<double, 2> focal_px = {};  ///< The median of the posterior of log f.
  std::array<double, 2> low_px = {};    ///< Where its central 68 % begin.
  std::array<double, 2> high_px = {};   ///< Where they end.
  /// Whether the matches say more than the prior does. False where the motion does not show the focal length (turning
  /// in place, moving straight ahead, one plane): then it is the prior's.
  std::array<bool, 2> observable = {};
  std::array<double, 2> prior_focal_px = {};   ///< The median of the prior.
  std::array<double, 2> prior_log_sigma = {};  ///< The standard deviation of its logarithm.
  /// Of the posteriors of both log f: 1 where they are one length. Two views know the ratio of two lengths far better
  /// than either of them.
  double log_correlation = 0.0;
};

}  // namespace diffsac
