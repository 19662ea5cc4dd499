#pragma once

#include <array>

namespace diffsac {

/// Of cameras in general, in longer sides of the image: the middle of the central 68 % (.59 to 1.38, so that log f has
/// a standard deviation of .43) of 14 + 16 e^(.8 n) mm, n normal, over 36 mm, by which Hold-Geoffroy and others ("A
/// deep perceptual measure for lens and camera calibration", TPAMI 2023) draw the focal lengths of photographs.
inline constexpr double kMedianFocal = 0.9;
inline constexpr double kFocalLogSigma = 0.43;

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
