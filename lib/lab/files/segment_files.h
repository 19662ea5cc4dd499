#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "diffsac/diffsac.h"
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

/// The same with what was estimated from each image's segments, one for each: in a group `estimate` of the image's,
///   vanishing_points   M × 3   homogeneous pixels, the surest first
///   assignment         N       0 for a segment of none, k for the kth
///   directions         M × 3   in the camera's frame; absent where K is unknown
///   values             M       how sure the network is; absent without one
///   K                  3 × 3   given or found; may be absent
///   horizon            3       (a, b, c): a x + b y + c = 0 in pixels; may be absent
/// and its attribute `status`. ReadSegments reads the file as any other.
void WriteSegments(const std::string& path, const std::vector<ImageSegments>& images,
                   const std::vector<VanishingPointsEstimate>& estimates);

}  // namespace diffsac
