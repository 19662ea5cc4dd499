#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "diffsac/core/random.h"

namespace diffsac {

/// The command `diffsac_prepare warp`: images seen as planes from other places, for training on homographies with real
/// features and their real mistakes. (After the homographic adaptation of DeTone et al., "SuperPoint", CVPR 2018
/// workshops.)
struct WarpRequest {
  std::string input, output;  ///< Folder of images; folder for the scenes' folders.
  int images = 16;            ///< At most so many, evenly spread over the folder; 0: all.
  int views = 6;              ///< Other views of each image.
  int max_image_size = 1024;  ///< Larger images are first reduced to this side; 0: never.
  std::uint64_t seed = 0;
  bool photograph = false;    ///< Whether a camera's blur, noise, tones and file replace the light blur and noise.
  double least_tilt = 0.0;    ///< Degrees.
  double greatest_tilt = 65;  ///< Degrees.
};

/// Writes `output`/<image>/1.png, 2.png …, H_1_2 …: what `pairs --format homographies` reads. A view is that of a
/// camera with the same focal length (1.2 times the longer side), which looks at the plane's centre, within a tenth of
/// its width, under a tilt of 0 to 65 degrees from any side, turned by 25 degrees (a standard deviation), from 0.6
/// to 1.6 times the distance; blurred, in other light and with noise, or as a small camera sees it (Photograph). What
/// lies outside the image is grey noise. Images that cannot be read are left out with a warning. Returns false when
/// `stop` ended it. Throws Error.
bool WarpImages(const WarpRequest& request, const std::atomic<bool>& stop);

/// A random view of a plane of `width` × `height` pixels under a tilt within this range, degrees: x2 ~ H x1.
Eigen::Matrix3d RandomView(int width, int height, double least_tilt, double greatest_tilt, Rng rng);

/// What a small camera makes of a grey 8-bit view, in this order (Healey and Kondepudy, "Radiometric CCD camera
/// calibration and noise estimation", PAMI 1994): exposure by -1.2 to 0.6 stops and a corner up to 40 % darker, in
/// linear light (gamma 2.2); defocus (Gaussian, σ of 0.4 to 1.5 px) and, of every other view, motion blur of up to 8
/// px; shot noise that grows with the light and read noise; a tone curve (gamma 0.8 to 1.25); JPEG of quality 25 to 90.
/// Depends on its arguments alone.
cv::Mat Photograph(const cv::Mat& view, const Rng& rng);

}  // namespace diffsac
