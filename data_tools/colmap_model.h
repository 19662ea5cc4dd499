#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "data_tools/image_source.h"

namespace diffsac {

/// A camera from COLMAP's, whose first pixel has its centre at (0.5, 0.5); any model that ColmapLens knows. Throws
/// Error beginning with `place`, as ColmapLens does.
LensCamera CameraOfColmap(const ColmapCamera& colmap, const std::string& place);

/// World-to-camera, of QW QX QY QZ TX TY TZ; none where the quaternion is no rotation or a value is not finite.
std::optional<RigidMotion> PoseOfColmap(const double* values);

/// The cameras of a file cameras.bin, or else of text, by their ids. Throws Error naming the file, and the line of
/// text: it cannot be read, ends early, has a camera model that is not known.
std::map<std::int64_t, LensCamera> ReadColmapCameras(const std::string& path);

/// The images of a model (FindColmapModel; text where it has both) with their cameras and poses. Their files are in the
/// folder `images`. Throws Error as above, and where an image has no camera.
std::vector<SourceImage> ReadColmapModel(const std::string& folder, const std::string& images);

}  // namespace diffsac
