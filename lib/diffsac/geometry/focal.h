#pragma once

#include <array>

namespace diffsac {

/// What is known of a focal length before any match is looked at: log-normal. Its median, in the unit of the points
/// that it goes with, and the standard deviation of its logarithm (.1: about ten per cent).
struct FocalPrior {
  double focal = 0.0;      ///< The median.
  double log_sigma = 0.0;  ///< The standard deviation of its logarithm.
};

/// What matches and prior say of the focal lengths of two images, together. Equal lengths have equal entries; a length
/// that was given is its own interval.
struct FocalEstimate {
  std::array<double, 2> focal_px = {};  ///< The median of the posterior of log f, for each image.
  std::array<double, 2> low_px = {};    ///< Where its central 68 % begin.
  std::array<double, 2> high_px = {};   ///< Where they end.
  /// Whether the matches say more than the prior does. False where the motion does not show the focal length (turning
  /// in place, moving straight ahead, one plane): then it is the prior's.
  bool observable = false;
  double prior_focal_px =
      0.0;  ///< The median of the prior, of the image whose length was not given (the first of two).
  double prior_log_sigma = 0.0;  ///< The standard deviation of its logarithm.
};

}  // namespace diffsac
