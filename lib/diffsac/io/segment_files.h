#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/geometry/points.h"
#include "diffsac/problem/image_pair.h"

namespace diffsac {

/// The name of a scene's file of line segments.
inline constexpr const char* kSegmentsFile = "segments.h5";

/// The line segments of one image, in pixels: a group of the file, by the image's name, with
///   segments           N × 4   x1 y1 x2 y2
///   vanishing_points   K × 3   homogeneous; may be absent
///   K                  3 × 3   the calibration; may be absent
///   size               2       width, height; may be absent
struct ImageSegments {
  std::string name;
  PointMatrix segments;
  std::vector<Eigen::Vector3d> vanishing_points;  ///< The truth; empty where it is unknown.
  std::optional<Eigen::Matrix3d> K;
  ImageSize size = {};
};

/// In the order of their names. Throws Error that names file and object.
std::vector<ImageSegments> ReadSegments(const std::string& path);

/// Writes the whole file, or leaves what was there. Throws Error.
void WriteSegments(const std::string& path, const std::vector<ImageSegments>& images);

}  // namespace diffsac
