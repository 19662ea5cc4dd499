#pragma once

#include <array>

namespace diffsac {

/// Focal lengths that contradict the matches: what was said of those of both images, and what the matches say alone,
/// with 68 % of it, in pixels.
struct FocalConflict {
  std::array<double, 2> said_px = {};   ///< By a calibration, or the median of the prior.
  std::array<double, 2> found_px = {};  ///< By the matches.
  std::array<double, 2> low_px = {};    ///< Where the interval of found_px begins.
  std::array<double, 2> high_px = {};   ///< Where it ends.
};

}  // namespace diffsac
