#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "diffsac/geometry/rigid_motion.h"
#include "lab/colmap/lens_camera.h"

namespace diffsac {

/// A camera from COLMAP's, whose first pixel has its centre at (0.5, 0.5); any model that ColmapLens knows. Throws
/// Error beginning with `place`, as ColmapLens does.
LensCamera CameraOfColmap(const ColmapCamera& colmap, const std::string& place);

/// World-to-camera, of QW QX QY QZ TX TY TZ; none where the quaternion is no rotation or a value is not finite.
std::optional<RigidMotion> PoseOfColmap(const double* values);

/// The cameras of a file cameras.bin, or else of text, by their ids; those that make no sense are left out, with a
/// warning. Throws Error naming the file: it cannot be read, ends early, is binary and has a camera model that is not
/// known.
std::map<std::int64_t, LensCamera> ReadColmapCameras(const std::string& path);

/// An image of a model: its file, its camera and its world-to-camera pose.
struct ModelImage {
  std::string file;
  LensCamera camera;
  RigidMotion pose;
};

/// Is told of each image: its name (empty where its line has none), the line, and what reads it, which throws Error for
/// an image without a camera or a sound pose.
using UseModelImage =
    std::function<void(const std::string& name, const std::string& place, const std::function<ModelImage()>& read)>;

/// The images of a model (FindColmapModel; text where it has both) with their cameras and poses. Their files are in the
/// folder `images`; text takes the rest of a line as a name, which may have blanks. Throws Error as above.
void ReadColmapModel(const std::string& folder, const std::string& images, const UseModelImage& use);

}  // namespace diffsac
