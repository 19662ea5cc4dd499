#pragma once

#include <opencv2/core.hpp>

#include "diffsac/core/random.h"

namespace diffsac {

/// What a small camera makes of a grey 8-bit view, in this order (Healey and Kondepudy, "Radiometric CCD camera
/// calibration and noise estimation", PAMI 1994): exposure by -1.2 to 0.6 stops and a corner up to 40 % darker, in
/// linear light (gamma 2.2); defocus (Gaussian, σ of 0.4 to 1.5 px) and, of every other view, motion blur of up to 8
/// px; shot noise that grows with the light and read noise; a tone curve (gamma 0.8 to 1.25); JPEG of quality 25 to 90.
/// Depends on its arguments alone.
cv::Mat Photograph(const cv::Mat& view, const Rng& rng);

}  // namespace diffsac
