#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/geometry/rigid_motion.h"
#include "lab/colmap/lens.h"

namespace diffsac {

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

/// Where a model is whose files end so, ".txt" or ".bin": the folder itself, colmap_ground_truth, sparse/0 or sparse in
/// it; empty when there is none.
std::string FindColmapModel(const std::string& folder, const std::string& extension);

}  // namespace diffsac
