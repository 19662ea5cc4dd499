#pragma once

#include "diffsac/geometry/rows_view.h"
#include "diffsac/problem/image_pair.h"

// What the functions of diffsac.h take. All members are views of the caller's memory (geometry/rows_view.h).
namespace diffsac {

/// 2D-2D correspondences: matched keypoints of two images.
struct Matches {
  Points2DView points1 = {};  ///< N × 2, in pixels.
  Points2DView points2 = {};  ///< N × 2, in pixels. Row i matches row i of `points1`.
  /// N: descriptor distance of the nearest neighbour over that of the second-nearest, from 0 to 1, lower is better.
  /// Empty: unknown. Ratios help more than anything else that can be given.
  ValuesView snn_ratio = {};
  ImageSize size1 = {};  ///< In pixels; {}: unknown. Helps F. Throws if more than 15 % of `points1` lie outside.
  ImageSize size2 = {};  ///< As `size1`.
  /// N × 2: log(size2 / size1) and angle2 − angle1 in radians, of the keypoints (cv::KeyPoint::size, and
  /// cv::KeyPoint::angle · π / 180). Empty: unknown. Helps E and F: the networks read it, and a match whose keypoints
  /// do not rotate as its epipolar lines do is weighted down.
  Points2DView scale_rotation_changes = {};
  /// N: confidences of a matcher (LightGlue), from 0 to 1, higher is better, instead of `snn_ratio`. Empty: unknown.
  /// Pass all matches: a filter by score (LightGlue's filter_threshold) loses more than it helps. No network is used.
  ValuesView scores = {};
};

/// 2D-3D correspondences: points of a scene and their places in an image.
struct Matches2D3D {
  Points3DView points3d = {};  ///< N × 3, in the scene's unit.
  Points2DView points2d = {};  ///< N × 2, in pixels.
  ValuesView snn_ratio = {};   ///< As Matches::snn_ratio.
  ValuesView scores = {};      ///< As Matches::scores.
};

/// 3D-3D correspondences: matched points of two clouds.
struct Matches3D3D {
  Points3DView points1 = {};  ///< N × 3, in the first cloud's unit.
  Points3DView points2 = {};  ///< N × 3. Row i matches row i of `points1`.
  ValuesView snn_ratio = {};  ///< As Matches::snn_ratio: orders the samples.
  ValuesView scores = {};     ///< As Matches::scores: orders the samples.
};

}  // namespace diffsac
