#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data_tools/image_source.h"

namespace diffsac {

/// How many parameters a camera model has, by COLMAP's name; 0 for one that LensCamera is not.
int ColmapParameterCount(const std::string& model);

/// A camera from COLMAP's, whose first pixel has its centre at (0.5, 0.5). As many parameters as ColmapParameterCount.
/// Throws Error beginning with `place` unless all are finite and focal lengths positive.
LensCamera CameraOfColmap(const std::string& model, const std::vector<double>& parameters, const ImageSize& size,
                          const std::string& place);

/// World-to-camera, of QW QX QY QZ TX TY TZ; none where the quaternion is no rotation or a value is not finite.
std::optional<RigidMotion> PoseOfColmap(const double* values);

/// The images of a binary model, cameras.bin and images.bin in `model`, whose files are in the folder `images`. Throws
/// Error naming the file: it cannot be read, ends early, has a camera model that is not supported or no camera for an
/// image.
std::vector<SourceImage> ReadColmapBinary(const std::string& model, const std::string& images);

}  // namespace diffsac
