#pragma once

#include <Eigen/Core>
#include <atomic>
#include <cstdint>
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
/// to 1.6 times the distance; blurred, in other light and with noise, or as a small camera sees it (photograph.h). What
/// lies outside the image is grey noise. Images that cannot be read are left out with a warning. Returns false when
/// `stop` ended it. Throws Error.
bool WarpImages(const WarpRequest& request, const std::atomic<bool>& stop);

/// A random view of a plane of `width` × `height` pixels under a tilt within this range, degrees: x2 ~ H x1.
Eigen::Matrix3d RandomView(int width, int height, double least_tilt, double greatest_tilt, Rng rng);

}  // namespace diffsac
